#include "frontend/matching/refinement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/geometry/angles.h"
#include "frontend/matching/match_covariance.h"

namespace arborslam {
namespace {

// The slope by which degenerate directions are told is measured over a wider step than the covariance's, for less
// noise: along corridors it then stays below 0.03 of the greatest, in orchards above 0.1.
constexpr double kDegeneracySteps = 2.0;
// The slope of a spoilt scan can vanish in any direction, by noise. So the pairs themselves must agree that they hold a
// direction weakly: against the greatest, 0.05 to 0.19 along corridors, in orchards mostly above 0.3.
constexpr double kMaxFixedRatio = 0.25;
// [m], by how much more MHD the prediction may cost than the pose found, along a direction that is degenerate.
constexpr double kGreatestDegenerateLoss = 0.01;

// A point beside the landmark it was matched to.
struct Pair {
  Eigen::Vector2f lever;     // [m], from the base to the point, target's axes.
  Eigen::Vector2f residual;  // [m], from the landmark to the point.
  float distance;            // [m]
  const MatchTarget::Landmark* landmark;
};

struct NormalEquations {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

class Refiner {
 public:
  Refiner(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const MhdOptions& mhd,
          const RefinementOptions& options)
      : target_(target), points_(points), mhd_options_(mhd), options_(options) {
    pairs_.reserve(points.size());
    distances_.reserve(points.size());
  }

  RefinementResult Run(const SE2& initial, const SE2& prediction, bool with_information) {
    RefinementResult result;
    result.pose = Iterate(initial, Eigen::Matrix3d::Identity(), &result.iterations);
    Associate(result.pose);
    FindDegenerate(result.pose, &result);
    if (result.num_degenerate > 0) {
      // Along the degenerate directions the search and the steps above went astray: go back to the prediction there,
      // and refine the others once more.
      const SE2 found = result.pose;
      const double found_score = mhd_.score;
      const Eigen::Matrix3d free = Eigen::Matrix3d::Identity() - Projector(result);
      const SE2 to_prediction = result.pose.Inverse() * prediction;
      const Eigen::Vector3d scale(1.0, 1.0, options_.lever_arm);
      const Eigen::Vector3d back =
          (Projector(result) * to_prediction.vector().cwiseProduct(scale)).cwiseQuotient(scale);
      result.pose = Iterate(result.pose * SE2(back.x(), back.y(), back.z()), free, &result.iterations);
      Associate(result.pose);
      // An unknown direction is one along which the pose may move at no cost. Where the way back costs, the direction
      // is known after all, if only over more than the slope's step: a turn among few trunks, found by a wide search.
      if (mhd_.score > found_score + kGreatestDegenerateLoss) {
        result.pose = found;
        result.num_degenerate = 0;
        Associate(result.pose);
      }
    }
    result.mhd = mhd_;
    if (with_information) result.information = Information(result.pose, result);
    return result;
  }

 private:
  // Fills pairs_ and mhd_ for a pose.
  void Associate(const SE2& pose) {
    pairs_.clear();
    distances_.clear();
    const Eigen::Matrix2f rotation = pose.rotation().cast<float>();
    const Eigen::Vector2f translation = pose.translation().cast<float>();
    const float max_distance = target_.field().max_distance();
    for (const Eigen::Vector2f& point : points_) {
      const Eigen::Vector2f lever = rotation * point;
      const Eigen::Vector2f position = lever + translation;
      const MatchTarget::Landmark* landmark = target_.Nearest(position);
      if (landmark == nullptr) {
        distances_.push_back(max_distance);
        continue;
      }
      const Eigen::Vector2f residual = position - landmark->centroid;
      const float distance = residual.norm();
      distances_.push_back(distance);
      pairs_.push_back({lever, residual, distance, landmark});
    }
    mhd_ = ModifiedHausdorff(&distances_, max_distance, mhd_options_);
  }

  float Weight(const Pair& pair) const {
    const auto scale = static_cast<float>(options_.robust_scale);
    return pair.landmark->weight * scale * scale / (scale * scale + pair.distance * pair.distance);
  }

  // The gradient's part of a pair, for a shift along the target's axes and a turn about the base.
  static Eigen::Vector3f Gradient(const Pair& pair, float weight) {
    const Eigen::Vector3f& information = pair.landmark->information;
    const Eigen::Vector2f force(information.x() * pair.residual.x() + information.y() * pair.residual.y(),
                                information.y() * pair.residual.x() + information.z() * pair.residual.y());
    return weight * Eigen::Vector3f(force.x(), force.y(), pair.lever.x() * force.y() - pair.lever.y() * force.x());
  }

  NormalEquations Accumulate() const {
    NormalEquations normal;
    const auto cutoff = static_cast<float>(mhd_.cutoff);
    for (const Pair& pair : pairs_) {
      if (pair.distance > cutoff) continue;
      const float weight = Weight(pair);
      const Eigen::Vector3f& w = pair.landmark->information;
      // Jacobian of the residual: [I, perp(lever)].
      const Eigen::Vector2f turn(-pair.lever.y(), pair.lever.x());
      const Eigen::Vector2f w_turn(w.x() * turn.x() + w.y() * turn.y(), w.y() * turn.x() + w.z() * turn.y());
      Eigen::Matrix3f hessian;
      hessian << w.x(), w.y(), w_turn.x(), w.y(), w.z(), w_turn.y(), w_turn.x(), w_turn.y(), turn.dot(w_turn);
      normal.hessian += (weight * hessian).cast<double>();
      normal.gradient += Gradient(pair, weight).cast<double>();
    }
    return normal;
  }

  // Gauss-Newton with steps confined to the image of `free` (x, y, theta * lever_arm; base frame).
  SE2 Iterate(const SE2& initial, const Eigen::Matrix3d& free, int* iterations) {
    SE2 pose = initial;
    const Eigen::Vector3d scale(1.0, 1.0, options_.lever_arm);
    for (int i = 0; i < options_.max_iterations; ++i) {
      Associate(pose);
      const NormalEquations normal = Accumulate();
      const Eigen::Matrix3d to_base = ToBase(pose);
      // Unit: a shift in metres, a turn in metres at the lever arm.
      const Eigen::Matrix3d jacobian = to_base.transpose() * scale.cwiseInverse().asDiagonal();
      Eigen::Matrix3d hessian = jacobian.transpose() * normal.hessian * jacobian;
      const Eigen::Vector3d gradient = free * jacobian.transpose() * normal.gradient;
      hessian = free * hessian * free + (Eigen::Matrix3d::Identity() - free);
      hessian.diagonal().array() += 1e-9 + 1e-6 * hessian.trace();
      const Eigen::Vector3d step = -hessian.ldlt().solve(gradient);
      pose = pose * SE2(step.x(), step.y(), step.z() / options_.lever_arm);
      ++*iterations;
      if (step.norm() < options_.min_step) break;
    }
    return pose;
  }

  // Rotates shifts from the target's axes to the base's.
  static Eigen::Matrix3d ToBase(const SE2& pose) {
    Eigen::Matrix3d to_base = Eigen::Matrix3d::Identity();
    to_base.topLeftCorner<2, 2>() = pose.rotation().transpose();
    return to_base;
  }

  static Eigen::Matrix3d Projector(const RefinementResult& result) {
    const auto basis = result.degenerate_basis.leftCols(result.num_degenerate);
    return basis * basis.transpose();
  }

  void FindDegenerate(const SE2& pose, RefinementResult* result) const {
    const Eigen::Vector3d to_metres(1.0, 1.0, 1.0 / options_.lever_arm);
    const Eigen::Matrix3d jacobian = ToBase(pose).transpose() * to_metres.asDiagonal();
    const Eigen::Matrix3d fixed = jacobian.transpose() * Accumulate().hessian * jacobian;
    const Eigen::Vector3d strength = fixed.selfadjointView<Eigen::Lower>().eigenvalues();
    const double fixed_limit = kMaxFixedRatio * strength.maxCoeff();
    if (strength.minCoeff() > fixed_limit) return;

    const Eigen::Matrix3d slope = ForceSlope(target_, points_, pose, mhd_options_,
                                             {options_.robust_scale, kDegeneracySteps * options_.covariance_step});
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(to_metres.asDiagonal() * slope * to_metres.asDiagonal());
    const double limit = options_.min_information_ratio * eigen.eigenvalues()(2);
    for (int i = 0; i < 3 && eigen.eigenvalues()(i) <= limit; ++i) {
      const Eigen::Vector3d direction = eigen.eigenvectors().col(i);
      if (direction.dot(fixed * direction) > fixed_limit) continue;
      result->degenerate_basis.col(result->num_degenerate++) = direction;
    }
  }

  Eigen::Matrix3d Information(const SE2& pose, const RefinementResult& result) const {
    // The directions that are free: the eigenvectors of the projector onto them that belong to 1, not to 0.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(Eigen::Matrix3d::Identity() - Projector(result));
    const Eigen::Matrix<double, 3, Eigen::Dynamic> free = eigen.eigenvectors().rightCols(3 - result.num_degenerate);
    const Eigen::Matrix3d measured =
        MatchInformation(target_, points_, pose, mhd_options_, {options_.robust_scale, options_.covariance_step},
                         options_.lever_arm, free);
    if (measured.isZero()) return measured;
    // The matched points lie within D_max of their landmarks: the pose cannot err by much more than half of that,
    // however noisy a spoilt scan makes the slope.
    const double most = 0.5 * static_cast<double>(target_.field().max_distance());
    const Eigen::Vector3d scale(1.0, 1.0, options_.lever_arm);
    return measured + scale.asDiagonal() * (free * free.transpose() / (most * most)) * scale.asDiagonal();
  }

  const MatchTarget& target_;
  const std::vector<Eigen::Vector2f>& points_;
  const MhdOptions mhd_options_;
  const RefinementOptions options_;
  std::vector<Pair> pairs_;
  std::vector<float> distances_;
  MhdResult mhd_;
};

}  // namespace

std::string RefinementOptions::Validate() const {
  std::ostringstream error;
  if (max_iterations < 1 || max_iterations > 1000) {
    error << "max_iterations is " << max_iterations << ", must lie in [1, 1000]";
  } else if (!(robust_scale > 0.0 && robust_scale <= 10.0)) {
    error << "robust_scale is " << robust_scale << " m, must lie in (0, 10]";
  } else if (!(min_step > 0.0 && min_step <= 0.1)) {
    error << "min_step is " << min_step << " m, must lie in (0, 0.1]";
  } else if (!(min_information_ratio >= 0.0 && min_information_ratio < 1.0)) {
    error << "min_information_ratio is " << min_information_ratio << ", must lie in [0, 1)";
  } else if (!(lever_arm > 0.0 && lever_arm <= 1000.0)) {
    error << "lever_arm is " << lever_arm << " m, must lie in (0, 1000]";
  } else if (!(covariance_step > 0.0 && covariance_step <= 1.0)) {
    error << "covariance_step is " << covariance_step << " m, must lie in (0, 1]";
  }
  return error.str();
}

RefinementResult Refine(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& initial,
                        const SE2& prediction, const MhdOptions& mhd, const RefinementOptions& options,
                        bool with_information) {
  return Refiner(target, points, mhd, options).Run(initial, prediction, with_information);
}

}  // namespace arborslam
