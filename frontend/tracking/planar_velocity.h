#ifndef ARBORSLAM_FRONTEND_TRACKING_PLANAR_VELOCITY_H_
#define ARBORSLAM_FRONTEND_TRACKING_PLANAR_VELOCITY_H_

#include <Eigen/Core>

#include "core/sensor/stamped_pose.h"

namespace arborslam {

/// Where the robot goes, in the plane.
struct PlanarVelocity {
  Eigen::Vector2d linear = Eigen::Vector2d::Zero();  ///< [m/s], in the base frame.
  double angular = 0.0;                              ///< [rad/s]

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(linear, angular);
  }
};

/// The constant velocity that leads from one pose to a later one, as seen half-way.
PlanarVelocity VelocityBetween(const StampedPose& from, const StampedPose& to);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_PLANAR_VELOCITY_H_
