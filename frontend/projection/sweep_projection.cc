#include "frontend/projection/sweep_projection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"

namespace arborslam {
namespace {

constexpr double kLn2 = 0.69314718055994531;
constexpr size_t kSectors = 720;
constexpr int kRangeSteps = 64;
constexpr float kLowObject = 0.4f;    // [m], the lowest thing that is mapped.
constexpr float kBlindRange = 2.5f;   // [m], from here on at the latest must the ground be in sight.
constexpr float kFreeMargin = 0.15f;  // [m], before a planar point.
constexpr size_t kLayers = 8;
constexpr float kLayerHeight = 0.5f;      // [m], how far over one another returns are looked at together.
constexpr float kRangeTolerance = 0.05f;  // [m], between returns from a solid thing, plus a column's width.
constexpr float kMinSolidity = 0.4f;
constexpr size_t kMinPoints = 200;
constexpr size_t kMaxPoints = 1000;
constexpr float kPiF = 3.14159265f;

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

SweepProjection::SweepProjection(const SweepProjectionOptions& options) : options_(options) {}

float SweepProjection::Solidity(const Cluster& cluster, size_t num_columns, float tolerance) const {
  // Of the bins of the columns before, of this and after it: returns, and those at the cluster's range.
  float all[3] = {0.0f, 0.0f, 0.0f};
  float near[3] = {0.0f, 0.0f, 0.0f};
  const size_t column = cluster.bin % num_columns;
  for (size_t k = 0; k < 3; ++k) {
    if ((k == 0 && column == 0) || (k == 2 && column + 1 == num_columns)) continue;
    const size_t bin = cluster.bin + k - 1;
    for (size_t i = bin == 0 ? 0 : bin_ends_[bin - 1]; i < bin_ends_[bin]; ++i) {
      all[k] += 1.0f;
      near[k] += std::abs(sorted_[i].range - cluster.range) <= tolerance ? 1.0f : 0.0f;
    }
  }
  const auto score = [](float n, float of) { return (n - 1.0f) / (of + 1.0f); };
  return std::max({score(near[1], all[1]), score(near[0] + near[1], all[0] + all[1]),
                   score(near[1] + near[2], all[1] + all[2]),
                   score(near[0] + near[1] + near[2], all[0] + all[1] + all[2])});
}

PlanarScan SweepProjection::Project(const Input& input, const Eigen::Matrix3f& R_base_lidar) {
  const std::vector<Eigen::Vector3f>& points = *input.points;
  const std::vector<float>& heights = *input.heights;
  const bool has_phases = !input.phases->empty();
  const auto min_range_squared = static_cast<float>(options_.min_range * options_.min_range);
  const auto max_range = static_cast<float>(options_.max_range);
  const auto max_bearing = static_cast<float>(options_.max_bearing);
  const auto ground_margin = static_cast<float>(options_.ground_margin);
  const auto ground_growth = static_cast<float>(options_.ground_growth);
  const auto num_columns = static_cast<size_t>(std::ceil(2.0f * kPiF / input.column_width)) + 1;
  const float inverse_width = 1.0f / input.column_width;
  constexpr float kInverseSector = static_cast<float>(kSectors) / (2.0f * kPiF);
  const float inverse_step = kRangeSteps / max_range;
  const Eigen::Matrix<float, 2, 3> to_plane = R_base_lidar.topRows<2>();
  const float over_object = input.lidar_height - kLowObject;

  kept_.clear();
  seen_.assign(kSectors, 0);
  nearest_.assign(kSectors, std::numeric_limits<float>::infinity());
  bin_ends_.assign(kLayers * num_columns + 1, 0);
  for (size_t i = 0; i < points.size(); ++i) {
    const float height = heights[i];
    // Eq. 6 for the upper end: see MinHeightLikelihood.
    if (!(height <= input.mean_canopy_height)) continue;
    const Eigen::Vector2f p = to_plane * points[i];
    const float range_squared = p.squaredNorm();
    if (!(range_squared >= min_range_squared)) continue;
    const float range = std::sqrt(range_squared);
    const float bearing = FastAtan2(p.y(), p.x());
    if (std::abs(bearing) > max_bearing) continue;
    const auto sector = std::min(kSectors - 1, static_cast<size_t>((bearing + kPiF) * kInverseSector));
    // The beam came down from the lidar in a straight line: from `low_from` on it was low enough to meet the lowest
    // object.
    if (height < kLowObject) {
      const float low_from = over_object > 0.0f ? range * over_object / (input.lidar_height - height) : 0.0f;
      const int from = static_cast<int>(low_from * inverse_step + 0.5f);
      const int to = std::min(kRangeSteps, static_cast<int>(range * inverse_step + 0.5f));
      if (from < to) {
        const uint64_t up_to = to == kRangeSteps ? ~uint64_t{0} : (uint64_t{1} << to) - 1;
        seen_[sector] |= up_to & ~((uint64_t{1} << from) - 1);
      }
    }
    if (height < ground_margin + ground_growth * range || range > max_range) continue;
    const auto column = static_cast<size_t>((bearing + kPiF) * inverse_width);
    const auto layer = std::min(kLayers - 1, static_cast<size_t>(height * (1.0f / kLayerHeight)));
    const auto bin = static_cast<uint32_t>(layer * num_columns + column);
    ++bin_ends_[bin + 1];
    kept_.push_back({p.x(), p.y(), range, has_phases ? (*input.phases)[i] : 0.0f, bin});
  }

  // Returns by bin, then by range; then bin_ends_[b] is where bin b ends.
  for (size_t b = 1; b < bin_ends_.size(); ++b) bin_ends_[b] += bin_ends_[b - 1];
  sorted_.resize(kept_.size());
  for (const Return& r : kept_) sorted_[bin_ends_[r.bin]++] = r;
  const auto depth = static_cast<float>(options_.column_depth);
  clusters_.clear();
  for (uint32_t begin = 0; begin < sorted_.size();) {
    const uint32_t bin = sorted_[begin].bin;
    const uint32_t end = bin_ends_[bin];
    std::sort(sorted_.begin() + begin, sorted_.begin() + end,
              [](const Return& a, const Return& b) { return a.range < b.range; });
    while (begin < end) {
      Cluster cluster{Eigen::Vector2f::Zero(), 0.0f, 0.0f, sorted_[begin].phase, 0.0f, bin};
      const float first_range = sorted_[begin].range;
      for (; begin < end && sorted_[begin].range <= first_range + depth; ++begin) {
        cluster.sum += Eigen::Vector2f(sorted_[begin].x, sorted_[begin].y);
        cluster.range += sorted_[begin].range;
        cluster.weight += 1.0f;
      }
      cluster.range /= cluster.weight;
      clusters_.push_back(cluster);
    }
  }
  solidities_.clear();
  for (Cluster& cluster : clusters_) {
    cluster.solidity = Solidity(cluster, num_columns, kRangeTolerance + input.column_width * cluster.range);
    solidities_.push_back(cluster.solidity);
  }
  float least = kMinSolidity;
  const auto nth_highest = [this](size_t n) {
    const auto nth = solidities_.begin() + static_cast<ptrdiff_t>(n);
    std::nth_element(solidities_.begin(), nth, solidities_.end(), std::greater<float>());
    return *nth;
  };
  if (solidities_.size() > kMaxPoints) least = std::max(least, nth_highest(kMaxPoints));
  least = std::min(least, solidities_.size() > kMinPoints ? nth_highest(kMinPoints) : -1.0f);
  solid_.clear();
  for (Cluster& cluster : clusters_) {
    if (cluster.solidity < least) continue;
    cluster.bin %= static_cast<uint32_t>(num_columns);
    solid_.push_back(cluster);
  }
  std::sort(solid_.begin(), solid_.end(),
            [](const Cluster& a, const Cluster& b) { return a.bin != b.bin ? a.bin < b.bin : a.range < b.range; });

  const auto spacing = static_cast<float>(options_.point_spacing);
  points_.clear();
  open_.clear();
  for (size_t begin = 0; begin < solid_.size();) {
    const uint32_t column = solid_[begin].bin;
    still_open_.clear();
    while (begin < solid_.size() && solid_[begin].bin == column) {
      Eigen::Vector2f sum = Eigen::Vector2f::Zero();
      float weight = 0.0f;
      const float first_range = solid_[begin].range;
      const float phase = solid_[begin].phase;
      for (; begin < solid_.size() && solid_[begin].bin == column && solid_[begin].range <= first_range + depth;
           ++begin) {
        sum += solid_[begin].sum;
        weight += solid_[begin].weight;
      }
      const Eigen::Vector2f mean = sum / weight;
      const auto joins = std::find_if(open_.begin(), open_.end(), [&](uint32_t k) {
        return points_[k].column + 1 >= column && (points_[k].first - mean).squaredNorm() < spacing * spacing;
      });
      uint32_t joined = 0;
      if (joins != open_.end()) {
        joined = *joins;
        points_[joined].sum += sum;
        points_[joined].weight += weight;
        points_[joined].column = column;
      } else {
        joined = static_cast<uint32_t>(points_.size());
        points_.push_back({sum, mean, weight, phase, column});
      }
      still_open_.push_back(joined);
    }
    std::swap(open_, still_open_);
  }

  PlanarScan scan;
  scan.point_rays_are_free = false;
  scan.points.reserve(points_.size());
  scan.weights.reserve(points_.size());
  if (has_phases) scan.phases.reserve(points_.size());
  for (const Point& point : points_) {
    scan.points.push_back(point.sum / point.weight);
    scan.weights.push_back(point.weight);
    if (has_phases) scan.phases.push_back(point.phase);
    const Eigen::Vector2f& p = scan.points.back();
    const auto sector = std::min(kSectors - 1, static_cast<size_t>((FastAtan2(p.y(), p.x()) + kPiF) * kInverseSector));
    nearest_[sector] = std::min(nearest_[sector], p.norm());
  }
  for (size_t s = 0; s < kSectors; ++s) {
    uint64_t seen = seen_[s];
    if (seen == 0) continue;
    int step = 0;
    while (((seen >> step) & 1) == 0) ++step;
    if (static_cast<float>(step) > kBlindRange * inverse_step) continue;
    while (step < kRangeSteps && ((seen >> step) & 1) != 0) ++step;
    const float nearest =
        std::min({nearest_[(s + kSectors - 1) % kSectors], nearest_[s], nearest_[(s + 1) % kSectors]});
    const float range = std::min(static_cast<float>(step) / inverse_step, nearest - kFreeMargin);
    if (!(range >= static_cast<float>(options_.min_range))) continue;
    const float bearing = (static_cast<float>(s) + 0.5f) / kInverseSector - kPiF;
    scan.free_ends.emplace_back(range * std::cos(bearing), range * std::sin(bearing));
  }
  return scan;
}

}  // namespace arborslam
