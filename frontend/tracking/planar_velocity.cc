#include "frontend/tracking/planar_velocity.h"

#include "core/geometry/se2.h"

namespace arborslam {

PlanarVelocity VelocityBetween(const StampedPose& from, const StampedPose& to) {
  const SE2 step = from.pose.Inverse() * to.pose;
  const double duration = to.stamp - from.stamp;
  // Along the chord, half the turn lies before its middle.
  return {SE2(0.0, 0.0, -0.5 * step.theta()) * Eigen::Vector2d(step.translation() / duration), step.theta() / duration};
}

}  // namespace arborslam
