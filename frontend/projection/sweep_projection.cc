#include "frontend/projection/sweep_projection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
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

PlanarScan SweepProjection::Project(const Input& input, const Eigen::Matrix3f& R_base_lidar) {
  const std::vector<Eigen::Vector3f>& points = *input.points;
  const std::vector<float>& heights = *input.heights;
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
  column_ends_.assign(num_columns + 1, 0);
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
    nearest_[sector] = std::min(nearest_[sector], range);
    const auto column = static_cast<uint32_t>((bearing + kPiF) * inverse_width);
    ++column_ends_[column + 1];
    kept_.push_back({p.x(), p.y(), range, column});
  }

  // Returns by column, then by range.
  for (size_t c = 1; c < column_ends_.size(); ++c) column_ends_[c] += column_ends_[c - 1];
  sorted_.resize(kept_.size());
  std::vector<uint32_t>& next = column_ends_;
  for (const Return& r : kept_) sorted_[next[r.column]++] = r;
  // Now column_ends_[c] is where column c ends.
  const auto depth = static_cast<float>(options_.column_depth);
  const auto spacing = static_cast<float>(options_.point_spacing);
  clusters_.clear();
  open_.clear();
  uint32_t begin = 0;
  for (size_t c = 0; c < num_columns; ++c) {
    const uint32_t end = column_ends_[c];
    if (begin == end) continue;
    std::sort(sorted_.begin() + begin, sorted_.begin() + end,
              [](const Return& a, const Return& b) { return a.range < b.range; });
    still_open_.clear();
    for (uint32_t i = begin; i < end;) {
      Eigen::Vector2f sum = Eigen::Vector2f::Zero();
      float weight = 0.0f;
      const float first_range = sorted_[i].range;
      for (; i < end && sorted_[i].range <= first_range + depth; ++i) {
        sum += Eigen::Vector2f(sorted_[i].x, sorted_[i].y);
        weight += 1.0f;
      }
      const Eigen::Vector2f mean = sum / weight;
      uint32_t joined = 0;
      const auto joins = std::find_if(open_.begin(), open_.end(), [&](uint32_t k) {
        return clusters_[k].column + 1 >= c && (clusters_[k].first - mean).squaredNorm() < spacing * spacing;
      });
      if (joins != open_.end()) {
        joined = *joins;
        clusters_[joined].sum += sum;
        clusters_[joined].weight += weight;
        clusters_[joined].column = static_cast<uint32_t>(c);
      } else {
        joined = static_cast<uint32_t>(clusters_.size());
        clusters_.push_back({sum, mean, weight, static_cast<uint32_t>(c)});
      }
      still_open_.push_back(joined);
    }
    std::swap(open_, still_open_);
    begin = end;
  }

  PlanarScan scan;
  scan.points.reserve(clusters_.size());
  scan.weights.reserve(clusters_.size());
  for (const Cluster& cluster : clusters_) {
    scan.points.push_back(cluster.sum / cluster.weight);
    scan.weights.push_back(cluster.weight);
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
