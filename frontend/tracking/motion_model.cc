#include "frontend/tracking/motion_model.h"

#include <algorithm>

#include "core/config/validation.h"
#include "core/geometry/angles.h"

namespace arborslam {

std::string MotionOptions::Validate() const {
  if (model != "constant_velocity" && model != "unicycle" && model != "omnidirectional") {
    return Violation("model", model, "be constant_velocity, unicycle or omnidirectional");
  }
  if (!(max_extrapolation >= 0.0 && max_extrapolation <= 100.0)) {
    return Violation("max_extrapolation", max_extrapolation, "lie in [0, 100]");
  }
  if (!(translation_sigma > 0.0)) return Violation("translation_sigma", translation_sigma, "be above 0 m");
  if (!(rotation_sigma > 0.0)) return Violation("rotation_sigma", rotation_sigma, "be above 0 rad");
  return "";
}

bool CanExtrapolate(double previous, double last, double stamp, const MotionOptions& options) {
  return last > previous && stamp > last && stamp - last <= options.max_extrapolation * (last - previous);
}

SE2 PredictPose(const StampedPose& previous, const StampedPose& last, double stamp, const MotionOptions& options) {
  if (!CanExtrapolate(previous.stamp, last.stamp, stamp, options)) return last.pose;
  const double stretch = (stamp - last.stamp) / (last.stamp - previous.stamp);
  if (options.model == "constant_velocity") {
    const Eigen::Vector2d translation =
        last.pose.translation() + stretch * (last.pose.translation() - previous.pose.translation());
    const double turn = AngleDifference(last.pose.theta(), previous.pose.theta());
    return SE2(translation.x(), translation.y(), last.pose.theta() + stretch * turn);
  }
  const SE2 step = previous.pose.Inverse() * last.pose;
  const double turn = step.theta();
  // The step as seen from its middle heading is the chord of an arc along which the velocity is constant in the robot's
  // frame; the next arc's chord lies half its own turn further.
  const Eigen::Vector2d chord = SE2(0.0, 0.0, -0.5 * turn) * step.translation();
  const double sideways = options.model == "unicycle" ? 0.0 : chord.y();
  const Eigen::Vector2d next =
      SE2(0.0, 0.0, 0.5 * stretch * turn) * Eigen::Vector2d(stretch * chord.x(), stretch * sideways);
  return last.pose * SE2(next.x(), next.y(), stretch * turn);
}

Eigen::Matrix3d MotionInformation(const Eigen::Vector3d& sigma) {
  return sigma.array().square().inverse().matrix().asDiagonal();
}

}  // namespace arborslam
