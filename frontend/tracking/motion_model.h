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
  double translation_sigma = 1.0;  ///< [m], the greatest standard deviation of a predicted step's x and y.
  double rotation_sigma = 1.0;     ///< [rad], the greatest standard deviation of a predicted step's turn.
  bool learn_sigma = true;         ///< Find out how far predictions really err; false: as far as that.

  /// [m, m, rad], of a prediction of which nothing better is known.
  Eigen::Vector3d GreatestSigma() const { return {translation_sigma, translation_sigma, rotation_sigma}; }

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("model", model);
    visit("max_extrapolation", max_extrapolation);
    visit("translation_sigma", translation_sigma);
    visit("rotation_sigma", rotation_sigma);
    visit("learn_sigma", learn_sigma);
  }
};

/// Whether a pose at `stamp` [s] can be told from those at `previous` and `last`: the stamps rise, and the gap is not
/// too long.
bool CanExtrapolate(double previous, double last, double stamp, const MotionOptions& options);

/// The pose at `stamp` [s] after the poses at `previous` and `last`; the last one where that cannot be told.
SE2 PredictPose(const StampedPose& previous, const StampedPose& last, double stamp, const MotionOptions& options);

/// The information (x, y, theta) [1/m^2, 1/rad^2] of a predicted step with these standard deviations [m, m, rad].
Eigen::Matrix3d MotionInformation(const Eigen::Vector3d& sigma);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_MOTION_MODEL_H_
