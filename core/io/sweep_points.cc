#include "core/io/sweep_points.h"

#include <cmath>

#include "core/error.h"

namespace arborslam {

bool AppendPoint(float x, float y, float z, LidarSweep* sweep) {
  const bool is_finite = std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
  if (!is_finite || (x == 0.0f && y == 0.0f && z == 0.0f)) {
    ++sweep->num_dropped;
    return false;
  }
  sweep->points.emplace_back(x, y, z);
  return true;
}

void RequireSweepSize(const std::string& path, uint64_t count) {
  if (count <= kMaxSweepPoints) return;
  throw UserError(
      path, "has " + std::to_string(count) + " points, but a sweep has at most " + std::to_string(kMaxSweepPoints),
      "check that it is one revolution of a lidar and undamaged");
}

}  // namespace arborslam
