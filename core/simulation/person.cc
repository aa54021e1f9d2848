#include "core/simulation/person.h"

namespace arborslam {
namespace {

constexpr double kStride = 0.3;     // [m], how far a foot is ahead of the hip at most.
constexpr double kHipOffset = 0.1;  // [m] from the middle to each leg.

}  // namespace

std::array<Frustum, 4> PersonAt(const SE2& place, double ground, double height, double swing) {
  const auto point = [&](double ahead, double left, double up) -> Eigen::Vector3d {
    const Eigen::Vector2d flat = place * Eigen::Vector2d(ahead, left);
    return {flat.x(), flat.y(), ground + up * height};
  };
  const double step = kStride * swing;
  return {Frustum::Between(point(step, kHipOffset, 0.0), point(0.0, kHipOffset, 0.5), 0.06, 0.09),
          Frustum::Between(point(-step, -kHipOffset, 0.0), point(0.0, -kHipOffset, 0.5), 0.06, 0.09),
          Frustum::Between(point(0.0, 0.0, 0.48), point(0.0, 0.0, 0.85), 0.17, 0.2),
          Frustum::Between(point(0.0, 0.0, 0.85), point(0.0, 0.0, 1.0), 0.08, 0.08)};
}

}  // namespace arborslam
