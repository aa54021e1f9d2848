#include "frontend/tracking/motion_filter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

// Errors of successive predictions are not independent.
constexpr double kSafety = 2.0;
// [m, m, rad], of predictions.
const Eigen::Vector3d kLeastSigma(0.02, 0.02, 0.01);
// [m/s^2, rad/s^2], standard deviation of how a robot may change its motion at any time: it can turn off or brake by
// much within a second, by hardly anything within a tenth of one.
constexpr double kInertia = 2.0;
// [m] and [rad], by which a step differs from the one before: at first, and at least.
constexpr double kFirstChange = 0.3;
constexpr double kLeastChange = 0.005;
constexpr double kLearningRate = 0.1;
// An error is squared, in standard deviations; beyond this one the robot changes its course.
constexpr double kGate = 9.0;
constexpr double kScatterShare = 0.1;  // Of the latest error, in the mean of the last few.
constexpr double kMostScatter = 4.0;   // Of one error.
constexpr double kLeastScatter = 0.04;
constexpr double kHardlyKnown = 0.25;  // Of the greatest variance: what a match claims no more than this of.

Eigen::Vector3d Counting(const Eigen::Vector3d& scatter) { return scatter.cwiseMax(kLeastScatter).cwiseMin(1.0); }

}  // namespace

MotionFilter::MotionFilter(const MotionOptions& options)
    : options_(options), change_(options.GreatestSigma().cwiseMin(kFirstChange)) {}

bool MotionFilter::CanTell(double step) const {
  return last_step_ > 0.0 && CanExtrapolate(-last_step_, 0.0, step, options_);
}

SE2 MotionFilter::Step(double step) const {
  // The velocity is that half-way between the last two scans, at their mean heading.
  const SE2 back = SE2(0.0, 0.0, -0.5 * last_step_ * velocity_.z());
  const Eigen::Vector2d chord = back * Eigen::Vector2d(-last_step_ * velocity_.head<2>());
  const SE2 previous(chord.x(), chord.y(), -last_step_ * velocity_.z());
  return PredictPose({-last_step_, previous}, {0.0, SE2()}, step, options_);
}

MotionFilter::Matrix6d MotionFilter::CovarianceAfter(double step) const {
  Matrix6d transition = Matrix6d::Identity();
  transition.topLeftCorner<3, 3>() = Step(step).Inverse().Adjoint();
  transition.topRightCorner<3, 3>() = step * Eigen::Matrix3d::Identity();
  Matrix6d covariance = transition * covariance_ * transition.transpose();
  // The velocity that leads from scan to scan changes between the steps, and more between long ones.
  const double stretch = std::max(1.0, step / last_step_);
  for (int axis = 0; axis < 3; ++axis) {
    const double change = stretch * stretch * change_[axis];
    covariance(axis, axis) += change * change;
    covariance(axis, axis + 3) += change * change / step;
    covariance(axis + 3, axis) += change * change / step;
    covariance(axis + 3, axis + 3) += change * change / (step * step);
  }
  return covariance;
}

Eigen::Vector3d MotionFilter::Sigma(const Eigen::Vector3d& variances, double step) const {
  // What matches claim to know is taken as it is when predictions are weighed against it: so their claims count here.
  const Eigen::Vector3d sigma = kSafety * variances.cwiseQuotient(Counting(scatter_)).cwiseSqrt();
  return sigma.cwiseMax(kLeastSigma).cwiseMax(0.5 * step * step * kInertia).cwiseMin(options_.GreatestSigma());
}

MotionFilter::Prediction MotionFilter::Predict(const StampedPose& last, double stamp) const {
  const double step = stamp - last.stamp;
  const Eigen::Vector3d most = options_.GreatestSigma();
  if (!CanTell(step)) return {last.pose, most, most};
  Prediction prediction{last.pose * Step(step), most, most};
  if (!options_.learn_sigma) return prediction;
  const Matrix6d covariance = CovarianceAfter(step);
  prediction.sigma = Sigma(covariance.diagonal().head<3>(), step);
  prediction.step_sigma = Sigma(step * step * covariance.diagonal().tail<3>(), step);
  return prediction;
}

void MotionFilter::Add(const StampedPose& last, const StampedPose& matched, const Eigen::Matrix3d& information) {
  const Eigen::Vector3d most = options_.GreatestSigma();
  const double step = matched.stamp - last.stamp;
  const bool can_tell = CanTell(step);
  if (!can_tell) {
    last_step_ = step;
    velocity_.setZero();
    covariance_.rightCols<3>().setZero();
    covariance_.bottomRows<3>().setZero();
    covariance_.bottomRightCorner<3, 3>() = (most / step).cwiseAbs2().asDiagonal();
  }
  const SE2 expected = Step(step);
  covariance_ = CovarianceAfter(step);
  last_step_ = step;
  const PlanarVelocity going_on = VelocityBetween({0.0, SE2()}, {step, expected});
  velocity_ << going_on.linear, going_on.angular;
  if (information.isZero(0.0)) return;

  const Eigen::Vector3d error = ((last.pose * expected).Inverse() * matched.pose).vector();
  // Axis by axis: how a direction that is not measured lies to the axes is not known well enough to tell a motion along
  // it by the noise across it.
  Eigen::Vector3d measured = (information + MotionInformation(most)).inverse().diagonal();
  if (can_tell) {
    covariance_ *= Learn(error, covariance_.diagonal().head<3>(), measured);
    measured = measured.cwiseProduct(Counting(scatter_)).eval();
  } else {
    // Nothing else tells how fast the robot is: where the match found it counts, though it hardly knows it.
    measured = (measured.array() > kHardlyKnown * most.array().square()).select(0.0, measured).eval();
  }
  const Eigen::Matrix3d total = covariance_.topLeftCorner<3, 3>() + Eigen::Matrix3d(measured.asDiagonal());
  const Eigen::Matrix<double, 6, 3> gain = covariance_.leftCols<3>() * total.inverse();
  velocity_ += gain.bottomRows<3>() * error;
  covariance_ -= (gain * covariance_.topRows<3>()).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

double MotionFilter::Learn(const Eigen::Vector3d& error, const Eigen::Vector3d& predicted,
                           const Eigen::Vector3d& measured) {
  const Eigen::Vector3d most = options_.GreatestSigma();
  double excess = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double square = error[axis] * error[axis];
    scatter_[axis] +=
        kScatterShare * (std::min(kMostScatter, square / (predicted[axis] + measured[axis])) - scatter_[axis]);
    const double variance = predicted[axis] + Counting(scatter_)[axis] * measured[axis];
    excess = std::max(excess, square / variance / kGate);
    // The less the prediction counts in the error, the less it is to blame.
    const double blame = 0.5 * kLearningRate * predicted[axis] / variance;
    change_[axis] *= std::exp(blame * (std::min(square / variance, kGate) - 1.0));
    change_[axis] = std::min(std::max(change_[axis], kLeastChange), most[axis]);
  }
  return excess;
}

}  // namespace arborslam
