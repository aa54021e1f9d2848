#include "core/simulation/leaves.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arborslam {
namespace {

// `vector` in the leaves' own frame, in which their extent is 1.
Eigen::Vector3d Scaled(const Leaves& leaves, const Eigen::Vector3d& vector) {
  const double c = std::cos(leaves.yaw);
  const double s = std::sin(leaves.yaw);
  return Eigen::Vector3d(c * vector.x() + s * vector.y(), c * vector.y() - s * vector.x(), vector.z())
      .cwiseQuotient(leaves.extent);
}

}  // namespace

Passage PassageThrough(const Leaves& leaves, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d start = Scaled(leaves, origin - leaves.center);
  const Eigen::Vector3d step = Scaled(leaves, direction);
  if (leaves.shape == Leaves::Shape::kEllipsoid) {
    const double a = step.squaredNorm();
    const double b = start.dot(step);
    const double discriminant = b * b - a * (start.squaredNorm() - 1.0);
    if (discriminant <= 0.0) return {};
    const double root = std::sqrt(discriminant);
    return {std::max(0.0, (-b - root) / a), (-b + root) / a};
  }
  Passage passage{0.0, std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    if (step[axis] == 0.0) {
      if (std::abs(start[axis]) > 1.0) return {};
      continue;
    }
    const double one = (-1.0 - start[axis]) / step[axis];
    const double other = (1.0 - start[axis]) / step[axis];
    passage.entry = std::max(passage.entry, std::min(one, other));
    passage.exit = std::min(passage.exit, std::max(one, other));
  }
  return passage;
}

}  // namespace arborslam
