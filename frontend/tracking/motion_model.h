#ifndef ARBORSLAM_FRONTEND_TRACKING_MOTION_MODEL_H_
#define ARBORSLAM_FRONTEND_TRACKING_MOTION_MODEL_H_

#include <string>

#include "core/sensor/stamped_pose.h"

namespace arborslam {

/// How the robot is taken to go on when nothing else is known.
struct MotionOptions {
  /// "constant_velocity": the translation goes on in the odometry frame while the heading turns at its rate;
  /// "unicycle": speed along the heading and turn rate, no sideways motion (paper eq. 13);
  /// "omnidirectional": forward and sideways speed and turn rate, all in the robot's frame.
  std::string model = "omnidirectional";
  double max_extrapolation =
      3.0;  ///< After a gap longer than this many steps the robot is taken to stand where it was.
  double translation_sigma = 1.0;  ///< [m], standard deviation of a predicted step's x and y.
  double rotation_sigma = 1.0;     ///< [rad], standard deviation of a predicted step's turn.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("model", model);
    visit("max_extrapolation", max_extrapolation);
    visit("translation_sigma", translation_sigma);
    visit("rotation_sigma", rotation_sigma);
  }
};

/// The pose at `stamp` [s] after the poses at `previous` and `last`; the last one where the stamps do not rise.
SE2 PredictPose(const StampedPose& previous, const StampedPose& last, double stamp, const MotionOptions& options);

/// The information (x, y, theta) [1/m^2, 1/rad^2] of a predicted step.
Eigen::Matrix3d MotionInformation(const MotionOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_MOTION_MODEL_H_
