#ifndef ARBORSLAM_FRONTEND_TRACKING_PLANAR_VELOCITY_H_
#define ARBORSLAM_FRONTEND_TRACKING_PLANAR_VELOCITY_H_

#include <Eigen/Core>

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

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_PLANAR_VELOCITY_H_
