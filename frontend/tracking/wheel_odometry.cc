#include "frontend/tracking/wheel_odometry.h"

#include <algorithm>
#include <cmath>

#include "core/config/validation.h"

namespace arborslam {
namespace {

// Errors of successive steps are not independent: a wheel that is worn errs to the same side all the time.
constexpr double kSafety = 1.5;
constexpr double kLeastStretch = 0.3;
constexpr double kGreatestStretch = 20.0;
// [m], farther no robot drives between two scans: the odometry was reset.
constexpr double kGreatestStep = 100.0;
// [m] and [rad], the least step of a robot that moves.
constexpr double kMinStep = 0.01;
constexpr double kMinTurn = 0.005;

// The standard deviations [m, m, rad] that `options` give a step.
Eigen::Vector3d SigmaBefore(const SE2& motion, const OdometryOptions& options) {
  const double way = motion.translation().norm();
  const double turn = std::abs(motion.theta());
  const double translation =
      std::hypot(options.translation_sigma, options.translation_per_metre * way, options.translation_per_turn * turn);
  const double rotation =
      std::hypot(options.rotation_sigma, options.rotation_per_metre * way, options.rotation_per_turn * turn);
  return {translation, translation, rotation};
}

}  // namespace

std::string OdometryOptions::Validate() const {
  if (!(translation_sigma > 0.0)) return Violation("translation_sigma", translation_sigma, "be above 0 m");
  if (!(rotation_sigma > 0.0)) return Violation("rotation_sigma", rotation_sigma, "be above 0 rad");
  if (!(translation_per_metre >= 0.0)) {
    return Violation("translation_per_metre", translation_per_metre, "be at least 0 m per m");
  }
  if (!(translation_per_turn >= 0.0)) {
    return Violation("translation_per_turn", translation_per_turn, "be at least 0 m per rad");
  }
  if (!(rotation_per_metre >= 0.0)) {
    return Violation("rotation_per_metre", rotation_per_metre, "be at least 0 rad per m");
  }
  if (!(rotation_per_turn >= 0.0)) {
    return Violation("rotation_per_turn", rotation_per_turn, "be at least 0 rad per rad");
  }
  if (!(submap_length > 0.0)) return Violation("submap_length", submap_length, "be above 0 m");
  return "";
}

WheelOdometry::WheelOdometry(const OdometryOptions& options) : options_(options) {}

std::optional<OdometryStep> WheelOdometry::Since(const std::optional<SE2>& from, const std::optional<SE2>& pose) const {
  if (!options_.enabled || !from || !pose) return std::nullopt;
  OdometryStep step;
  step.motion = from->Inverse() * *pose;
  if (step.motion.translation().norm() > kGreatestStep) return std::nullopt;
  step.sigma = SigmaBefore(step.motion, options_).cwiseProduct(stretch_);
  return step;
}

void WheelOdometry::Commit(const std::optional<SE2>& pose, bool is_keyframe) {
  has_odometry_ = has_odometry_ || pose.has_value();
  last_scan_ = pose;
  if (is_keyframe) last_keyframe_ = pose;
}

void WheelOdometry::Learn(const OdometryStep& step, const SE2& matched, const Eigen::Matrix3d& information) {
  if (!options_.learn_sigma) return;
  if (matched.translation().norm() < kMinStep && std::abs(matched.theta()) < kMinTurn) return;
  const Eigen::Vector3d error = (step.motion.Inverse() * matched).vector();
  const Eigen::Vector3d before = SigmaBefore(step.motion, options_);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    // What the other directions do not share: an optimistic figure, but 0 where nothing is known.
    if (information(axis, axis) * step.sigma[axis] * step.sigma[axis] < 1.0) continue;
    ErrorQuantile& errors = errors_[static_cast<size_t>(axis)];
    errors.Add(error[axis] / before[axis]);
    const std::optional<double> learned = errors.Sigma(kSafety);
    if (learned) stretch_[axis] = std::clamp(*learned, kLeastStretch, kGreatestStretch);
  }
}

}  // namespace arborslam
