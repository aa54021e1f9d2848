#ifndef ARBORSLAM_FRONTEND_TRACKING_MOTION_NOISE_H_
#define ARBORSLAM_FRONTEND_TRACKING_MOTION_NOISE_H_

#include <Eigen/Core>
#include <array>

#include "core/geometry/se2.h"
#include "frontend/tracking/error_quantile.h"
#include "frontend/tracking/motion_model.h"

namespace arborslam {

/// How far predictions of a robot's motion err, learned from the run itself: a cart that is seen ten times a second
/// hardly leaves its course between two sweeps, a trotting robot does, and one that is seen every few seconds may be
/// anywhere. Where the scan says little, at a headland for instance, a prediction that is known to be good holds the
/// pose. For one thread.
class MotionNoise {
 public:
  /// Until enough predictions were seen to err, errors are those of `options`, which are also the greatest.
  explicit MotionNoise(const MotionOptions& options);

  /// Takes how a prediction erred, if the match knows that better than the noise is known already.
  /// @param last_pose   of the scan before; a robot that stands tells nothing about how it moves.
  /// @param prediction  for the scan.
  /// @param matched     its measured pose, in the same frame.
  /// @param information of `matched`, (x, y, theta) in its own frame [1/m^2, 1/rad^2].
  void Add(const SE2& last_pose, const SE2& prediction, const SE2& matched, const Eigen::Matrix3d& information);

  /// Standard deviations [m, m, rad] of a prediction's x, y (in the robot's frame) and theta.
  /// More than usual while predictions err to the same side again and again, as they do when the robot brakes.
  Eigen::Vector3d sigma() const;

  /// The same of a prediction for `stamp` [s] from scans at `previous` and `last` [s]: more after a longer step, and
  /// never less than what inertia lets a robot do that went steadily so far: it can turn off or brake by much within a
  /// second, by hardly anything within a tenth of one. The greatest where nothing is learned or predicted.
  Eigen::Vector3d SigmaAt(double previous, double last, double stamp) const;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(sigma_, bias_, errors_);
  }

 private:
  MotionOptions options_;
  Eigen::Vector3d sigma_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();  // [m, m, rad], mean of the last few errors.
  std::array<ErrorQuantile, 3> errors_;             // [m, m, rad]
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_MOTION_NOISE_H_
