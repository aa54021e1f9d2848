#include "core/simulation/frustum.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arborslam {

Frustum Frustum::Between(const Eigen::Vector3d& base, const Eigen::Vector3d& top, double base_radius,
                         double top_radius) {
  const Eigen::Vector3d extent = top - base;
  return {base, extent.normalized(), extent.norm(), base_radius, top_radius};
}

double Intersect(const Frustum& frustum, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  // The side: |p - base|^2 - h^2 = (r + k h)^2 with h = (p - base).axis and p = origin + range * direction.
  const double taper = (frustum.top_radius - frustum.base_radius) / frustum.length;
  const Eigen::Vector3d offset = origin - frustum.base;
  const double rise = direction.dot(frustum.axis);
  const double start = offset.dot(frustum.axis);
  const double stretch = 1.0 + taper * taper;
  const double a = 1.0 - stretch * rise * rise;
  const double b = offset.dot(direction) - stretch * start * rise - taper * frustum.base_radius * rise;
  const double c = offset.squaredNorm() - stretch * start * start - 2.0 * taper * frustum.base_radius * start -
                   frustum.base_radius * frustum.base_radius;
  const double discriminant = b * b - a * c;
  double nearest = kInfinity;
  if (discriminant >= 0.0 && a != 0.0) {
    const double root = std::sqrt(discriminant);
    for (const double range : {(-b - root) / a, (-b + root) / a}) {
      const double along = start + range * rise;
      // Beyond its tip the equation describes the mirrored cone.
      if (range > 0.0 && range < nearest && along >= 0.0 && along <= frustum.length) nearest = range;
    }
  }
  if (rise < 0.0 && start > frustum.length) {
    const double range = (frustum.length - start) / rise;
    const Eigen::Vector3d across = offset + range * direction - frustum.length * frustum.axis;
    if (across.squaredNorm() <= frustum.top_radius * frustum.top_radius) nearest = std::min(nearest, range);
  }
  return nearest;
}

}  // namespace arborslam
