#include "frontend/projection/laser_projection.h"

#include <cmath>

#include "core/config/validation.h"
#include "core/geometry/angles.h"

namespace arborslam {

std::string ProjectionOptions::Validate() const {
  if (!(min_range >= 0.0)) return Violation("min_range", min_range, "be at least 0 m");
  if (!(max_range > min_range && max_range <= 1000.0)) {
    return Violation("max_range", max_range, "lie in (min_range, 1000] m");
  }
  if (!(max_bearing > 0.0 && max_bearing <= 3.15)) return Violation("max_bearing", max_bearing, "lie in (0, 3.15] rad");
  if (!(point_spacing >= 0.0 && point_spacing <= 1.0)) {
    return Violation("point_spacing", point_spacing, "lie in [0, 1] m");
  }
  return "";
}

PlanarScan ProjectLaserScan(const LaserScan& scan, const ProjectionOptions& options) {
  PlanarScan planar;
  planar.stamp = scan.stamp;
  planar.points.reserve(scan.ranges.size());
  const auto spacing = static_cast<float>(options.point_spacing);
  // A run of neighbouring returns within `spacing` of its first becomes their mean.
  Eigen::Vector2f run_first = Eigen::Vector2f::Zero();
  Eigen::Vector2f run_sum = Eigen::Vector2f::Zero();
  int run_length = 0;
  const auto end_run = [&] {
    if (run_length > 0) planar.points.push_back(run_sum / static_cast<float>(run_length));
    run_length = 0;
  };
  for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    const double range = scan.ranges[beam];
    const double bearing = NormalizeAngle(scan.Bearing(beam));
    if (!std::isfinite(range) || range < options.min_range || std::abs(bearing) > options.max_bearing) continue;
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    if (range > options.max_range) {
      planar.free_ends.push_back((options.max_range * direction).cast<float>());
      continue;
    }
    const Eigen::Vector2f point = (range * direction).cast<float>();
    if (run_length > 0 && (point - run_first).norm() >= spacing) end_run();
    if (run_length == 0) {
      run_first = point;
      run_sum.setZero();
    }
    run_sum += point;
    ++run_length;
  }
  end_run();
  return planar;
}

}  // namespace arborslam
