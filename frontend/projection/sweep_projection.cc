#include "frontend/projection/sweep_projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <limits>

#include "core/config/validation.h"
#include "core/cpu_clones.h"
#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"

namespace arborslam {
namespace {

constexpr double kLn2 = 0.69314718055994531;
constexpr float kPiF = 3.14159265f;
constexpr size_t kSectors = 720;
constexpr float kInverseSector = static_cast<float>(kSectors) / (2.0f * kPiF);
constexpr int kRangeSteps = 64;
constexpr float kEndStep = static_cast<float>(kRangeSteps);
constexpr float kLowObject = 0.4f;       // [m], the lowest thing that is mapped by a lidar close to the ground,
constexpr float kLowObjectShare = 0.5f;  // and, as a share of its height, by one far above it.
constexpr float kBlindRange = 3.0f;      // [m], from here on at the latest must the ground be in sight.
constexpr float kFreeMargin = 0.15f;     // [m], before something solid.
constexpr int kLanes = 8;                // Returns that are compared at once.
using Lanes = float __attribute__((vector_size(sizeof(float) * kLanes)));
using IntLanes = int __attribute__((vector_size(sizeof(int) * kLanes)));
constexpr IntLanes kLaneIndices = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr size_t kMostLayers = 8;
constexpr float kLayerHeight = 0.5f;      // [m], how far over one another returns are looked at together.
constexpr float kRangeTolerance = 0.05f;  // [m], between returns from a solid thing, plus a column's width.
constexpr float kHalfWidth = 0.03f;       // [m], how far to the sides returns are compared, at least one column,
constexpr int kMostColumns = 3;           // at most this many.
constexpr float kMinSolidity = 0.45f;
constexpr float kLowMargin = 0.09f;     // [m], from here on up narrow things are told from grass,
constexpr float kLowGrowth = 0.004f;    // [m] more per m of range.
constexpr uint32_t kMinLowColumns = 4;  // They are seen in at least so many columns,
constexpr float kMaxLowWidth = 0.8f;    // [m], and no wider than this.
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
constexpr size_t kMinClusters = 50;  // Less solid ones are kept up to this number.
constexpr size_t kMaxClusters = 1000;

int SectorOf(float bearing) {
  return std::min(static_cast<int>(kSectors) - 1, static_cast<int>((bearing + kPiF) * kInverseSector));
}

}  // namespace

std::string SweepProjectionOptions::Validate() const {
  if (!(min_range >= 0.0)) return Violation("min_range", min_range, "be at least 0 m");
  if (!(max_range > min_range && max_range <= 1000.0)) {
    return Violation("max_range", max_range, "lie in (min_range, 1000] m");
  }
  if (!(max_bearing > 0.0 && max_bearing <= 3.15)) return Violation("max_bearing", max_bearing, "lie in (0, 3.15] rad");
  if (!(ground_margin >= 0.0 && ground_margin <= 2.0)) {
    return Violation("ground_margin", ground_margin, "lie in [0, 2] m");
  }
  if (!(ground_growth >= 0.0 && ground_growth <= 0.2))
    return Violation("ground_growth", ground_growth, "lie in [0, 0.2]");
  if (!(mean_canopy_height >= 0.0 && mean_canopy_height <= 50.0)) {
    return Violation("mean_canopy_height", mean_canopy_height, "lie in [0, 50] m");
  }
  if (!(column_width >= 0.0 && column_width <= 5.0))
    return Violation("column_width", column_width, "lie in [0, 5] deg");
  if (!(column_depth >= 0.0 && column_depth <= 5.0)) return Violation("column_depth", column_depth, "lie in [0, 5] m");
  if (!(point_spacing >= 0.0 && point_spacing <= 1.0)) {
    return Violation("point_spacing", point_spacing, "lie in [0, 1] m");
  }
  return "";
}

double HeightLikelihood(double z, double mean_canopy_height) {
  const double lambda = kLn2 / mean_canopy_height;
  return z >= 0.0 ? lambda * std::exp(-lambda * z) : 0.0;
}

double MinHeightLikelihood(double mean_canopy_height) { return 0.5 * kLn2 / mean_canopy_height; }

SweepProjection::SweepProjection(const SweepProjectionOptions& options) : options_(options) {
  for (size_t s = 0; s < kSectors; ++s) {
    const float bearing = (static_cast<float>(s) + 0.5f) / kInverseSector - kPiF;
    directions_.emplace_back(std::cos(bearing), std::sin(bearing));
  }
}

PlanarScan SweepProjection::Project(const Input& input, const Eigen::Matrix3f& R_base_lidar) {
  Select(input, R_base_lidar);
  KeepLowThings(input.column_width);
  MakeClusters();
  FindSolid(input.column_width);
  MakePoints();

  PlanarScan scan;
  scan.point_rays_are_free = false;
  scan.points.reserve(points_.size());
  scan.weights.reserve(points_.size());
  const bool has_phases = input.phases != nullptr && !input.phases->empty();
  if (has_phases) scan.phases.reserve(points_.size());
  for (const Point& point : points_) {
    scan.points.push_back(point.sum / point.weight);
    scan.weights.push_back(point.weight);
    if (has_phases) scan.phases.push_back(point.phase);
  }
  AddFreeRays(&scan);
  return scan;
}

ARBORSLAM_CPU_CLONES void SweepProjection::Select(const Input& input, const Eigen::Matrix3f& R_base_lidar) {
  const std::vector<Eigen::Vector3f>& points = *input.points;
  const std::vector<float>& heights = *input.heights;
  const float* const phases = input.phases != nullptr && !input.phases->empty() ? input.phases->data() : nullptr;
  const auto min_range = static_cast<float>(options_.min_range);
  const auto max_range = static_cast<float>(options_.max_range);
  const auto max_bearing = static_cast<float>(options_.max_bearing);
  const auto ground_margin = static_cast<float>(options_.ground_margin);
  const auto ground_growth = static_cast<float>(options_.ground_growth);
  const float most_height = input.mean_canopy_height;
  const float inverse_width = 1.0f / input.column_width;
  const float inverse_step = kRangeSteps / max_range;
  const float low_object = std::max(kLowObject, kLowObjectShare * input.lidar_height);
  const float over_object = std::max(0.0f, input.lidar_height - low_object);

  num_columns_ = static_cast<size_t>(std::ceil(2.0f * kPiF * inverse_width)) + 1;
  const size_t num_layers = std::min(kMostLayers, static_cast<size_t>(std::max(0.0f, most_height) / kLayerHeight) + 1);
  kept_.clear();
  low_.clear();
  low_of_column_.assign(num_columns_, kNone);
  bin_ends_.assign(num_layers * num_columns_ + 1, 0);
  seen_.assign(kSectors, 0);
  first_.assign(kSectors, std::numeric_limits<float>::infinity());

  // In blocks: first what the compiler can vectorise.
  constexpr size_t kBlock = 64;
  std::array<float, kBlock> x;
  std::array<float, kBlock> y;
  std::array<float, kBlock> z;
  std::array<float, kBlock> range;
  std::array<float, kBlock> bearing;
  std::array<int, kBlock> sector;
  std::array<int, kBlock> column_of;
  std::array<int, kBlock> low_from;
  std::array<int, kBlock> low_to;
  std::array<int, kBlock> shows_free;  // 1: yes.
  std::array<int, kBlock> is_low;
  std::array<int, kBlock> is_object;
  std::array<uint32_t, kBlock> found;
  const Eigen::Matrix3f r = R_base_lidar;
  const auto num_columns = static_cast<uint32_t>(num_columns_);
  const auto last_layer = static_cast<uint32_t>(num_layers - 1);
  int last_sector = 0;
  float first = first_[0];  // Of the last sector.
  for (size_t begin = 0; begin < points.size(); begin += kBlock) {
    const size_t size = std::min(kBlock, points.size() - begin);
    const float* const height = heights.data() + begin;
    for (size_t i = 0; i < size; ++i) {
      x[i] = points[begin + i].x();
      y[i] = points[begin + i].y();
      z[i] = points[begin + i].z();
    }
    for (size_t i = 0; i < size; ++i) {
      const float base_x = r(0, 0) * x[i] + r(0, 1) * y[i] + r(0, 2) * z[i];
      const float base_y = r(1, 0) * x[i] + r(1, 1) * y[i] + r(1, 2) * z[i];
      x[i] = base_x;
      y[i] = base_y;
      range[i] = std::sqrt(base_x * base_x + base_y * base_y);
      bearing[i] = FastAtan2(base_y, base_x);
      // The beam came down from the lidar in a straight line: from here on it was low enough to meet the lowest object.
      const float from = range[i] * over_object / (over_object + low_object - height[i]);
      low_from[i] = static_cast<int>(std::max(0.0f, std::min(from * inverse_step + 0.5f, kEndStep)));
      low_to[i] = static_cast<int>(std::min(range[i] * inverse_step + 0.5f, kEndStep));
      sector[i] = SectorOf(bearing[i]);
      column_of[i] = static_cast<int>((bearing[i] + kPiF) * inverse_width);
    }
    for (size_t i = 0; i < size; ++i) {
      // Eq. 6: see MinHeightLikelihood.
      const int is_wanted = static_cast<int>(height[i] <= most_height) & static_cast<int>(range[i] >= min_range) &
                            static_cast<int>(std::abs(bearing[i]) <= max_bearing);
      const float margin = ground_margin + ground_growth * range[i];
      const float low_margin = std::min(margin, kLowMargin + kLowGrowth * range[i]);
      const int is_near = is_wanted & static_cast<int>(range[i] <= max_range);
      shows_free[i] = is_wanted & static_cast<int>(height[i] < low_object) & static_cast<int>(low_from[i] < low_to[i]);
      is_low[i] = static_cast<int>(height[i] < margin);
      is_object[i] = is_near & static_cast<int>(height[i] >= low_margin);
    }
    // What is noted of which return cannot be foreseen: first they are counted, without branches.
    const auto find = [&](const std::array<int, kBlock>& is_one) {
      size_t num_found = 0;
      for (size_t i = 0; i < size; ++i) {
        found[num_found] = static_cast<uint32_t>(i);
        num_found += static_cast<size_t>(is_one[i]);
      }
      return num_found;
    };
    size_t num_found = find(shows_free);
    for (size_t k = 0; k < num_found; ++k) {
      const uint32_t i = found[k];
      const uint64_t up_to = low_to[i] == kRangeSteps ? ~uint64_t{0} : (uint64_t{1} << low_to[i]) - 1;
      seen_[static_cast<size_t>(sector[i])] |= up_to & ~((uint64_t{1} << low_from[i]) - 1);
    }
    num_found = find(is_object);
    for (size_t k = 0; k < num_found; ++k) {
      const uint32_t i = found[k];
      const auto column = static_cast<uint32_t>(column_of[i]);
      const float phase = phases != nullptr ? phases[begin + i] : 0.0f;
      if (is_low[i] != 0) {
        low_.push_back({{x[i], y[i], range[i], phase, column}, low_of_column_[column]});
        low_of_column_[column] = static_cast<uint32_t>(low_.size() - 1);
        continue;
      }
      if (sector[i] != last_sector) {
        first_[static_cast<size_t>(last_sector)] = first;
        last_sector = sector[i];
        first = first_[static_cast<size_t>(last_sector)];
      }
      first = std::min(first, range[i]);
      const auto layer = std::min(last_layer, static_cast<uint32_t>(std::max(0.0f, height[i]) / kLayerHeight));
      const uint32_t bin = layer * num_columns + column;
      ++bin_ends_[bin + 1];
      // Number by number: a whole one would be put together in memory first, which costs a stall.
      Return& kept = kept_.emplace_back();
      kept.x = x[i];
      kept.y = y[i];
      kept.range = range[i];
      kept.phase = phase;
      kept.bin = bin;
    }
  }
  first_[static_cast<size_t>(last_sector)] = first;
}

void SweepProjection::KeepLowThings(float column_width) {
  low_runs_.clear();
  open_.clear();
  for (uint32_t column = 0; column < num_columns_; ++column) {
    still_open_.clear();
    for (uint32_t i = low_of_column_[column]; i != kNone; i = low_[i].next) {
      const Return& low = low_[i].value;
      const auto joined = std::find_if(open_.begin(), open_.end(), [&](uint32_t k) {
        return std::abs(low_runs_[k].range - low.range) <= kRangeTolerance;
      });
      low_[i].run = joined != open_.end() ? *joined : static_cast<uint32_t>(low_runs_.size());
      if (joined == open_.end()) low_runs_.push_back({low.range, column, column});
      low_runs_[low_[i].run].range = low.range;
      low_runs_[low_[i].run].last_column = column;
      still_open_.push_back(low_[i].run);
    }
    std::swap(open_, still_open_);
  }
  for (const LowReturn& low : low_) {
    const LowRun& run = low_runs_[low.run];
    const uint32_t num_columns = run.last_column - run.first_column + 1;
    const float width = static_cast<float>(num_columns) * column_width * run.range;
    if (num_columns < kMinLowColumns || width > kMaxLowWidth) continue;
    ++bin_ends_[low.value.bin + 1];
    kept_.push_back(low.value);
  }
}

void SweepProjection::MakeClusters() {
  // After this, bin_ends_[b] is where bin b begins; after filling it, where it ends.
  for (size_t b = 1; b < bin_ends_.size(); ++b) bin_ends_[b] += bin_ends_[b - 1];
  sorted_.resize(kept_.size());
  for (const Return& r : kept_) sorted_[bin_ends_[r.bin]++] = r;
  // What lies beyond the end is read along with the last ones, and not counted.
  ranges_.resize(sorted_.size() + kLanes);
  const auto depth = static_cast<float>(options_.column_depth);
  const auto num_columns = static_cast<uint32_t>(num_columns_);
  uint32_t layer_begin = 0;  // Its first bin.
  clusters_.clear();
  for (uint32_t begin = 0; begin < sorted_.size();) {
    const uint32_t bin = sorted_[begin].bin;
    while (bin >= layer_begin + num_columns) layer_begin += num_columns;
    const uint32_t end = bin_ends_[bin];
    // By insertion: a bin has a few returns.
    for (uint32_t i = begin + 1; i < end; ++i) {
      const Return moved = sorted_[i];
      uint32_t to = i;
      for (; to > begin && sorted_[to - 1].range > moved.range; --to) sorted_[to] = sorted_[to - 1];
      sorted_[to] = moved;
    }
    while (begin < end) {
      Cluster cluster{Eigen::Vector2f::Zero(), 0.0f, 0.0f, sorted_[begin].phase, 0.0f, bin, bin - layer_begin};
      const float first_range = sorted_[begin].range;
      for (; begin < end && sorted_[begin].range <= first_range + depth; ++begin) {
        ranges_[begin] = sorted_[begin].range;
        cluster.sum += Eigen::Vector2f(sorted_[begin].x, sorted_[begin].y);
        cluster.range += sorted_[begin].range;
        cluster.weight += 1.0f;
      }
      cluster.range /= cluster.weight;
      clusters_.push_back(cluster);
    }
  }
}

ARBORSLAM_CPU_CLONES float SweepProjection::Solidity(const Cluster& cluster, float column_width) const {
  const float tolerance = kRangeTolerance + column_width * cluster.range;
  const int side = std::clamp(static_cast<int>(kHalfWidth / (cluster.range * column_width)), 1, kMostColumns);
  const auto bin = static_cast<int>(cluster.bin);
  const auto column = static_cast<int>(cluster.column);
  const int left = bin - std::min(side, column);
  const int right = bin + std::min(side, static_cast<int>(num_columns_) - 1 - column);
  // The bins of a layer follow one another: those to the left, the cluster's own, those to the right.
  const auto begin_of = [this](int b) { return b == 0 ? 0 : static_cast<int>(bin_ends_[static_cast<size_t>(b - 1)]); };
  const int ends[4] = {begin_of(left), begin_of(bin), begin_of(bin + 1), begin_of(right + 1)};
  // Of kLanes returns at once, -1 for each that is near; those of each part are added up.
  const Lanes range = Lanes{} + cluster.range;
  const IntLanes own_begin = IntLanes{} + ends[1];
  const IntLanes own_end = IntLanes{} + ends[2];
  const IntLanes end = IntLanes{} + ends[3];
  IntLanes before_own{};
  IntLanes before_right{};
  IntLanes before_end{};
  for (int i = ends[0]; i < ends[3]; i += kLanes) {
    Lanes distance;
    std::memcpy(&distance, &ranges_[static_cast<size_t>(i)], sizeof(distance));
    distance -= range;
    const IntLanes is_near = (distance <= tolerance) & (distance >= -tolerance);
    const IntLanes index = kLaneIndices + i;
    before_own -= is_near & (index < own_begin);
    before_right -= is_near & (index < own_end);
    before_end -= is_near & (index < end);
  }
  const auto sum = [](const IntLanes& lanes) {
    int total = 0;
    for (int lane = 0; lane < kLanes; ++lane) total += lanes[lane];
    return total;
  };
  const int num_near[4] = {0, sum(before_own), sum(before_right), sum(before_end)};
  // Seen at the edge of a trunk, only one of the sides is solid.
  const auto score = [&](size_t from, size_t to) {
    const auto n = static_cast<float>(num_near[to] - num_near[from]);
    const auto m = static_cast<float>(ends[to] - ends[from]);
    return (n - 1.0f) / (m + 1.0f);
  };
  return std::max({score(1, 2), score(0, 2), score(1, 3), score(0, 3)});
}

void SweepProjection::FindSolid(float column_width) {
  solidities_.resize(clusters_.size());
  size_t num_solid = 0;
  for (size_t i = 0; i < clusters_.size(); ++i) {
    solidities_[i] = clusters_[i].solidity = Solidity(clusters_[i], column_width);
    num_solid += solidities_[i] >= kMinSolidity ? 1 : 0;
  }
  const auto nth_highest = [this](size_t n) {
    const auto nth = solidities_.begin() + static_cast<ptrdiff_t>(n);
    std::nth_element(solidities_.begin(), nth, solidities_.end(), std::greater<float>());
    return *nth;
  };
  float least = kMinSolidity;
  if (num_solid > kMaxClusters) least = nth_highest(kMaxClusters);
  if (num_solid < kMinClusters) least = clusters_.size() > kMinClusters ? nth_highest(kMinClusters) : 0.0f;

  KeepEdges(column_width, least);

  solid_.clear();
  nearest_.assign(kSectors, std::numeric_limits<float>::infinity());
  const float inverse_width = static_cast<float>(kSectors) / (2.0f * kPiF / column_width);
  for (Cluster& cluster : clusters_) {
    if (cluster.solidity <= 0.0f && least > 0.0f) continue;
    const auto sector =
        std::min(kSectors - 1, static_cast<size_t>((static_cast<float>(cluster.column) + 0.5f) * inverse_width));
    nearest_[sector] = std::min(nearest_[sector], cluster.range);
    if (cluster.solidity >= least) solid_.push_back(cluster);
  }
  std::sort(solid_.begin(), solid_.end(), [](const Cluster& a, const Cluster& b) {
    return a.column != b.column ? a.column < b.column : a.range < b.range;
  });
}

void SweepProjection::KeepEdges(float column_width, float least) {
  edges_.clear();
  for (size_t i = 0; i < clusters_.size(); ++i) {
    const Cluster& solid = clusters_[i];
    if (solid.solidity < least) continue;
    const float tolerance = kRangeTolerance + column_width * solid.range;
    const size_t num_edges = edges_.size();
    bool is_alone = true;
    const auto look = [&](size_t k) {
      if (std::abs(clusters_[k].range - solid.range) > tolerance) return;
      if (clusters_[k].solidity < least) edges_.push_back(k);
      if (clusters_[k].solidity >= least && clusters_[k].bin != solid.bin) is_alone = false;
    };
    // The bins of a layer follow one another.
    for (size_t k = i; k-- > 0 && clusters_[k].bin + 1 >= solid.bin;) look(k);
    for (size_t k = i + 1; k < clusters_.size() && clusters_[k].bin <= solid.bin + 1; ++k) look(k);
    // Leaves that met at one range by chance.
    if (is_alone) edges_.resize(num_edges);
  }
  for (const size_t k : edges_) clusters_[k].solidity = least;
}

void SweepProjection::MakePoints() {
  const auto depth = static_cast<float>(options_.column_depth);
  const auto spacing = static_cast<float>(options_.point_spacing);
  points_.clear();
  open_.clear();
  for (size_t begin = 0; begin < solid_.size();) {
    const uint32_t column = solid_[begin].column;
    still_open_.clear();
    while (begin < solid_.size() && solid_[begin].column == column) {
      Eigen::Vector2f sum = Eigen::Vector2f::Zero();
      float weight = 0.0f;
      const float last_range = solid_[begin].range + depth;
      const float phase = solid_[begin].phase;
      for (; begin < solid_.size() && solid_[begin].column == column && solid_[begin].range <= last_range; ++begin) {
        sum += solid_[begin].sum;
        weight += solid_[begin].weight;
      }
      const Eigen::Vector2f mean = sum / weight;
      const auto joined = std::find_if(open_.begin(), open_.end(), [&](uint32_t k) {
        return points_[k].column + 1 >= column && (points_[k].first - mean).squaredNorm() < spacing * spacing;
      });
      if (joined != open_.end()) {
        Point& point = points_[*joined];
        point.sum += sum;
        point.weight += weight;
        point.column = column;
        still_open_.push_back(*joined);
      } else {
        still_open_.push_back(static_cast<uint32_t>(points_.size()));
        points_.push_back({sum, mean, weight, phase, column});
      }
    }
    std::swap(open_, still_open_);
  }
}

void SweepProjection::AddFreeRays(PlanarScan* scan) const {
  const auto step_length = static_cast<float>(options_.max_range) / kRangeSteps;
  for (size_t s = 0; s < kSectors; ++s) {
    const Eigen::Vector2f& direction = directions_[s];
    if (std::isfinite(first_[s])) scan->first_returns.push_back(first_[s] * direction);
    const uint64_t seen = seen_[s];
    if (seen == 0) continue;
    const int first_seen = __builtin_ctzll(seen);
    if (static_cast<float>(first_seen) * step_length > kBlindRange) continue;
    const uint64_t not_seen = ~(seen >> first_seen);
    const int step = not_seen == 0 ? kRangeSteps : first_seen + __builtin_ctzll(not_seen);
    const float nearest =
        std::min({nearest_[(s + kSectors - 1) % kSectors], nearest_[s], nearest_[(s + 1) % kSectors]});
    const float range = std::min(static_cast<float>(step) * step_length, nearest - kFreeMargin);
    if (!(range >= static_cast<float>(options_.min_range))) continue;
    scan->free_ends.push_back(range * direction);
  }
}

}  // namespace arborslam
