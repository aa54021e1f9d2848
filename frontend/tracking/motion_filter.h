#ifndef ARBORSLAM_FRONTEND_TRACKING_MOTION_FILTER_H_
#define ARBORSLAM_FRONTEND_TRACKING_MOTION_FILTER_H_

#include <Eigen/Core>

#include "core/geometry/se2.h"
#include "core/sensor/stamped_pose.h"
#include "frontend/tracking/motion_model.h"
#include "frontend/tracking/planar_velocity.h"

namespace arborslam {

/// Where a robot is going, filtered from how its scans were matched: a Kalman filter on pose and velocity, whose
/// velocity changes at random from step to step (Bar-Shalom et al. 2001, ch. 6). Matches that know little hardly change
/// the course, but several that err to one side, as when the robot brakes, do.
///
/// Both noises are learned from the run. How much steps differ: a cart that is seen ten times a second hardly leaves
/// its course between two sweeps, a trotting robot does, and one that is seen every few seconds may be anywhere. And
/// how far matches scatter: along a wall of leaves they say that they know little, because nothing but their agreement
/// with those before shows that they know more (innovation-based, after Mehra 1972). For one thread.
class MotionFilter {
 public:
  /// `options` must be valid.
  explicit MotionFilter(const MotionOptions& options);

  /// What is expected of a scan.
  struct Prediction {
    SE2 pose;
    /// Standard deviations [m, m, rad] of x, y (in the robot's frame) and theta: of the pose, and of the step from the
    /// scan before alone; to be weighed against what matches say of themselves. Never less than what inertia lets a
    /// robot do that went steadily so far, nor more than the options have it; that where nothing can be told.
    Eigen::Vector3d sigma;
    Eigen::Vector3d step_sigma;
  };

  /// The prediction for `stamp` [s], `last` being the last scan at its present pose. After a gap, and from the first
  /// scan, a robot is taken to stand.
  Prediction Predict(const StampedPose& last, double stamp) const;

  /// Takes a scan.
  /// @param last        the scan before it at its present pose.
  /// @param matched     as the scan was matched, in the same frame.
  /// @param information of that, (x, y, theta) in its own frame [1/m^2, 1/rad^2]; 0: it was not matched.
  void Add(const StampedPose& last, const StampedPose& matched, const Eigen::Matrix3d& information);

  /// As of the last scan; 0 before the second one.
  PlanarVelocity velocity() const { return {velocity_.head<2>(), velocity_.z()}; }

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(velocity_, covariance_, change_, scatter_, last_step_);
  }

 private:
  using Matrix6d = Eigen::Matrix<double, 6, 6>;

  // Whether the velocity says anything about a step of `step` [s].
  bool CanTell(double step) const;
  // Of `step` [s] from the last scan on.
  SE2 Step(double step) const;
  Matrix6d CovarianceAfter(double step) const;
  // Learns from how a prediction erred, of the variances `predicted`, by a match of variances `measured`. Returns by
  // how much the former must be greater for this error.
  double Learn(const Eigen::Vector3d& error, const Eigen::Vector3d& predicted, const Eigen::Vector3d& measured);
  Eigen::Vector3d Sigma(const Eigen::Vector3d& variances, double step) const;

  MotionOptions options_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // [m/s, m/s, rad/s], in the robot's frame.
  Matrix6d covariance_ = Matrix6d::Zero();              // Of the last scan's pose, in its own frame, and the velocity.
  Eigen::Vector3d change_;  // [m, m, rad], standard deviation of how much a step differs from the one before.
  // Variances of matches over those that they claim; within kLeastScatter and 1 it counts.
  Eigen::Vector3d scatter_ = Eigen::Vector3d::Ones();
  double last_step_ = 0.0;  // [s], between the last two scans; 0: there are none.
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_MOTION_FILTER_H_
