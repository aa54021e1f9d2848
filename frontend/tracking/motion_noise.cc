#include "frontend/tracking/motion_noise.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace arborslam {
namespace {

const Eigen::Vector3d kLeast(0.02, 0.02, 0.01);
// Errors of successive predictions are not independent: a braking robot errs to the same side all the time.
constexpr double kSafety = 2.0;
constexpr double kBiasShare = 0.2;  // Of the latest error, in the mean of the last few.
constexpr double kBiasWeight = 4.0;
// [m/s^2, rad/s^2], standard deviations of how a robot may change its motion at any time.
constexpr double kLinearAcceleration = 2.0;
constexpr double kAngularAcceleration = 2.0;
// [m] and [rad], the least step of a robot that moves.
constexpr double kMinStep = 0.02;
constexpr double kMinTurn = 0.01;

}  // namespace

MotionNoise::MotionNoise(const MotionOptions& options) : options_(options), sigma_(options.GreatestSigma()) {}

void MotionNoise::Add(const SE2& last_pose, const SE2& prediction, const SE2& matched,
                      const Eigen::Matrix3d& information) {
  const Eigen::Vector3d error = (prediction.Inverse() * matched).vector();
  bias_ += kBiasShare * (error - bias_);
  const SE2 step = last_pose.Inverse() * matched;
  if (step.translation().norm() < kMinStep && std::abs(step.theta()) < kMinTurn) return;
  const Eigen::Vector3d most = options_.GreatestSigma();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    // What the other directions do not share: an optimistic figure, but 0 where nothing is known.
    if (information(axis, axis) * sigma_[axis] * sigma_[axis] < 1.0) continue;
    ErrorQuantile& errors = errors_[static_cast<size_t>(axis)];
    errors.Add(error[axis]);
    const std::optional<double> learned = errors.Sigma(kSafety);
    if (learned) sigma_[axis] = std::min(std::max(*learned, kLeast[axis]), most[axis]);
  }
}

Eigen::Vector3d MotionNoise::sigma() const {
  return (sigma_.array().square() + (kBiasWeight * bias_).array().square())
      .sqrt()
      .matrix()
      .cwiseMin(options_.GreatestSigma());
}

Eigen::Vector3d MotionNoise::SigmaAt(double previous, double last, double stamp) const {
  const Eigen::Vector3d most = options_.GreatestSigma();
  if (!options_.learn_sigma || !CanExtrapolate(previous, last, stamp, options_)) return most;
  const double step = stamp - last;
  const double stretch = std::max(1.0, step / (last - previous));
  const Eigen::Vector3d inertia(kLinearAcceleration, kLinearAcceleration, kAngularAcceleration);
  return (stretch * sigma()).cwiseMax(0.5 * step * step * inertia).cwiseMin(most);
}

}  // namespace arborslam
