#include "frontend/matching/match_covariance.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace arborslam {
namespace {

// [m], edge of the patches of ground within which residuals are taken to err together.
constexpr float kPatchSize = 1.0f;
// Patches are told apart by the last bits of their place: those that share a slot lie 16 m apart.
constexpr int kPatchesAcross = 16;
// [m^2], variance of the map that a perfect fit (simulated or tiny) does not show.
constexpr double kLeastVariance = 1e-6;

// Of a slope, what a wider step leaves at least.
constexpr double kLeastRatio = 0.01;
// The step is widened by at most this.
constexpr double kGreatestWidening = 4.0;

// The force on a pose, (x, y, theta) in the base frame, and on the range offset of all points, in that order.
using Force = Eigen::Vector4d;

class EstimatingFunction {
 public:
  EstimatingFunction(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const MhdOptions& mhd,
                     double robust_scale)
      : target_(target),
        points_(points),
        mhd_(mhd),
        squared_scale_(static_cast<float>(robust_scale * robust_scale)),
        landmarks_(points.size()),
        residuals_(points.size()),
        distances_(points.size()) {
    directions_.reserve(points.size());
    for (const Eigen::Vector2f& point : points) directions_.push_back(point.stableNormalized());
  }

  // Calls visit(centroid of the landmark, force) for the K best points when every point is moved away from the base by
  // `range_offset` [m].
  template <class Visit>
  void ForEachForce(const SE2& pose, float range_offset, const Visit& visit) {
    const Eigen::Matrix2f rotation = pose.rotation().cast<float>();
    const Eigen::Vector2f translation = pose.translation().cast<float>();
    for (size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector2f lever = points_[i] + range_offset * directions_[i];
      const Eigen::Vector2f position = rotation * lever + translation;
      const MatchTarget::Landmark* landmark = target_.Nearest(position);
      residuals_[i] = landmark ? Eigen::Vector2f(position - landmark->centroid) : Eigen::Vector2f::Zero();
      distances_[i] = landmark ? residuals_[i].norm() : target_.field().max_distance();
      landmarks_[i] = landmark;
    }
    order_ = distances_;
    const auto cutoff = static_cast<float>(ModifiedHausdorff(&order_, target_.field().max_distance(), mhd_).cutoff);
    for (size_t i = 0; i < points_.size(); ++i) {
      if (landmarks_[i] == nullptr || distances_[i] > cutoff) continue;
      const Eigen::Vector3f& shape = landmarks_[i]->information;
      const Eigen::Vector2f& residual = residuals_[i];
      const float weight = landmarks_[i]->weight * squared_scale_ / (squared_scale_ + residual.squaredNorm());
      const Eigen::Vector2f in_target(shape.x() * residual.x() + shape.y() * residual.y(),
                                      shape.y() * residual.x() + shape.z() * residual.y());
      const Eigen::Vector2f force = weight * (rotation.transpose() * in_target);
      const Eigen::Vector2f lever = points_[i] + range_offset * directions_[i];
      const float turn = lever.x() * force.y() - lever.y() * force.x();
      const float stretch = directions_[i].dot(force);
      visit(landmarks_[i]->centroid, Eigen::Vector4f(force.x(), force.y(), turn, stretch).cast<double>());
    }
  }

  Force Total(const SE2& pose, float range_offset) {
    Force total = Force::Zero();
    ForEachForce(pose, range_offset, [&](const Eigen::Vector2f&, const Force& force) { total += force; });
    return total;
  }

 private:
  const MatchTarget& target_;
  const std::vector<Eigen::Vector2f>& points_;
  const MhdOptions mhd_;
  const float squared_scale_;
  std::vector<Eigen::Vector2f> directions_;  // Of the points as seen from the base.
  // Per point, at the pose last looked at:
  std::vector<const MatchTarget::Landmark*> landmarks_;
  std::vector<Eigen::Vector2f> residuals_;  // [m], target's axes.
  std::vector<float> distances_;            // [m]
  std::vector<float> order_;                // The same, reordered.
};

// Typical distance of the points from the base [m], at least `least`: there a turn moves a point as a shift does.
double TypicalRange(const std::vector<Eigen::Vector2f>& points, double least) {
  double sum = 0.0;
  for (const Eigen::Vector2f& point : points) sum += point.squaredNorm();
  return std::max(least, std::sqrt(sum / static_cast<double>(points.size())));
}

// How the force on the pose changes with the pose; a turn moves points by `step` [m] at `range` [m].
Eigen::Matrix3d PoseSlope(const SE2& pose, double step, double range, EstimatingFunction* function) {
  Eigen::Matrix3d slope;
  const Eigen::Vector3d steps(step, step, step / range);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d move = steps(i) * Eigen::Vector3d::Unit(i);
    const SE2 ahead = pose * SE2(move.x(), move.y(), move.z());
    const SE2 behind = pose * SE2(-move.x(), -move.y(), -move.z());
    slope.col(i) = (function->Total(ahead, 0.0f) - function->Total(behind, 0.0f)).head<3>() / (2.0 * steps(i));
  }
  return 0.5 * (slope + slope.transpose());
}

// `near` (positive definite) shrunk along the directions in which `far` is less.
Eigen::MatrixXd Lesser(const Eigen::MatrixXd& near, const Eigen::MatrixXd& far) {
  const Eigen::MatrixXd root = near.llt().matrixL();
  const Eigen::MatrixXd half = root.triangularView<Eigen::Lower>().solve(far);
  const Eigen::MatrixXd ratio = root.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd(half.transpose()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (ratio + ratio.transpose()));
  const Eigen::MatrixXd axes = root * eigen.eigenvectors();
  return axes * eigen.eigenvalues().cwiseMax(kLeastRatio).cwiseMin(1.0).asDiagonal() * axes.transpose();
}

// How the force, also that on the range offset, changes with the range offset.
Force RangeOffsetSlope(const SE2& pose, double step, EstimatingFunction* function) {
  const auto offset = static_cast<float>(step);
  return (function->Total(pose, offset) - function->Total(pose, -offset)) / (2.0 * step);
}

}  // namespace

Eigen::Matrix3d ForceSlope(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& pose,
                           const MhdOptions& mhd, const MatchCovarianceOptions& options) {
  if (points.empty() || target.empty()) return Eigen::Matrix3d::Zero();
  EstimatingFunction function(target, points, mhd, options.robust_scale);
  return PoseSlope(pose, options.step, TypicalRange(points, options.step), &function);
}

Eigen::Matrix3d MatchInformation(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& pose,
                                 const MhdOptions& mhd, const MatchCovarianceOptions& options, double lever_arm,
                                 const Eigen::Matrix<double, 3, Eigen::Dynamic>& free_directions) {
  if (points.empty() || target.empty() || free_directions.cols() == 0) return Eigen::Matrix3d::Zero();
  EstimatingFunction function(target, points, mhd, options.robust_scale);

  std::array<Force, kPatchesAcross * kPatchesAcross> patches;
  patches.fill(Force::Zero());
  Force total = Force::Zero();
  function.ForEachForce(pose, 0.0f, [&](const Eigen::Vector2f& centroid, const Force& force) {
    const int x = static_cast<int>(std::floor(centroid.x() / kPatchSize)) & (kPatchesAcross - 1);
    const int y = static_cast<int>(std::floor(centroid.y() / kPatchSize)) & (kPatchesAcross - 1);
    patches[static_cast<size_t>(x * kPatchesAcross + y)] += force;
    total += force;
  });
  Eigen::Matrix3d patch_spread = Eigen::Matrix3d::Zero();
  int num_patches = 0;
  for (const Force& patch : patches) {
    patch_spread += patch.head<3>() * patch.head<3>().transpose();
    num_patches += patch.squaredNorm() > 0.0;
  }
  if (num_patches <= 3) return Eigen::Matrix3d::Zero();
  patch_spread *= num_patches / (num_patches - 3.0);

  // Turns in metres at the lever arm, so that the directions can be compared.
  const Eigen::Vector3d scale(1.0, 1.0, 1.0 / lever_arm);
  const Eigen::MatrixXd to_free = scale.asDiagonal() * free_directions;
  const Eigen::MatrixXd from_free = scale.cwiseInverse().asDiagonal() * free_directions;
  const double range = TypicalRange(points, options.step);
  const auto robust_weight = [&options](double distance) {
    return 1.0 / (1.0 + distance * distance / (options.robust_scale * options.robust_scale));
  };
  Eigen::MatrixXd information;
  Eigen::Matrix3d slope = PoseSlope(pose, options.step, range, &function);
  for (double step = options.step;; step *= 2.0) {
    const Force by_offset = RangeOffsetSlope(pose, step, &function);
    Eigen::Matrix3d spread = patch_spread;
    if (by_offset(3) > 0.0) {
      const double offset = std::clamp(-total(3) / by_offset(3), -step, step);
      spread += offset * offset * by_offset.head<3>() * by_offset.head<3>().transpose();
    }
    // Where the force does not pull back at all, nothing is known.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(to_free.transpose() * slope * to_free);
    Eigen::MatrixXd pull =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(1e-9).asDiagonal() * eigen.eigenvectors().transpose();
    // What holds a pose firmly does so over a wider step as well, but for what the robust weights take away.
    const double loss = robust_weight(step) / robust_weight(2.0 * step);
    const Eigen::Matrix3d wide_slope = PoseSlope(pose, 2.0 * step, range, &function);
    pull = Lesser(pull, to_free.transpose() * Eigen::Matrix3d(loss * wide_slope) * to_free);
    const Eigen::MatrixXd free_spread = to_free.transpose() * spread * to_free + kLeastVariance * pull;
    information = pull * free_spread.ldlt().solve(pull);
    information = (0.5 * (information + information.transpose())).eval();
    const double least = information.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
    if (least * step * step >= 1.0 || step >= kGreatestWidening * options.step) break;
    slope = wide_slope;
  }
  return from_free * information * from_free.transpose();
}

}  // namespace arborslam
