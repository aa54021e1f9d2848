#include "core/evaluation/alignment.h"

#include <Eigen/SVD>
#include <cmath>
#include <stdexcept>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

// Relative to the largest coordinate: spreads below this are rounding (UTM coordinates are near 6e6 m).
constexpr double kCoincidenceTolerance = 1e-12;
// Relative to the product of the spreads: correlations below this say nothing about the rotation.
constexpr double kCorrelationTolerance = 1e-9;

template <typename Points>
void CheckSizes(const Points& from, const Points& to) {
  if (from.cols() == 0 || from.cols() != to.cols()) {
    throw std::invalid_argument("an alignment needs two sets of as many points, and at least one, but has " +
                                std::to_string(from.cols()) + " and " + std::to_string(to.cols()));
  }
}

// The norm of all deviations from the mean, or 0 if they are nothing but rounding.
template <typename Points>
double Spread(const Points& points, const Points& centred) {
  const double spread = centred.norm();
  const double rounding = kCoincidenceTolerance * std::sqrt(static_cast<double>(points.cols()));
  return spread <= rounding * points.cwiseAbs().maxCoeff() ? 0.0 : spread;
}

// Right-handed axes: x along `direction` (unit length), y level, z as far up as that allows.
Eigen::Matrix3d UprightFrame(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d level = Eigen::Vector3d::UnitZ().cross(direction);
  const Eigen::Vector3d y = level.norm() > 1e-9 ? level.normalized() : Eigen::Vector3d::UnitY();
  Eigen::Matrix3d frame;
  frame << direction, y, direction.cross(y);
  return frame;
}

SE2 PlanarPose(const StampedPose3& pose) {
  return SE2(pose.position.x(), pose.position.y(), Heading(pose.orientation));
}

Eigen::Isometry3d ToIsometry(const SE2& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear().topLeftCorner<2, 2>() = pose.rotation();
  T.translation().head<2>() = pose.translation();
  return T;
}

}  // namespace

std::string ToString(AlignmentKind kind) {
  switch (kind) {
    case AlignmentKind::kNone:
      return "none";
    case AlignmentKind::kOrigin:
      return "origin";
    case AlignmentKind::kSe2:
      return "se2";
    case AlignmentKind::kSe3:
      return "se3";
  }
  throw std::invalid_argument("no such alignment");
}

std::optional<AlignmentKind> ParseAlignmentKind(const std::string& name) {
  for (const AlignmentKind kind :
       {AlignmentKind::kNone, AlignmentKind::kOrigin, AlignmentKind::kSe2, AlignmentKind::kSe3}) {
    if (name == ToString(kind)) return kind;
  }
  return std::nullopt;
}

double Heading(const Eigen::Quaterniond& orientation) {
  const Eigen::Vector3d x_axis = orientation * Eigen::Vector3d::UnitX();
  return NormalizeAngle(std::atan2(x_axis.y(), x_axis.x()));
}

SE2 UmeyamaSe2(const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to) {
  CheckSizes(from, to);
  const Eigen::Vector2d from_mean = from.rowwise().mean();
  const Eigen::Vector2d to_mean = to.rowwise().mean();
  const Eigen::Matrix2Xd a = from.colwise() - from_mean;
  const Eigen::Matrix2Xd b = to.colwise() - to_mean;
  const double cosine = (a.row(0).dot(b.row(0)) + a.row(1).dot(b.row(1)));
  const double sine = (a.row(0).dot(b.row(1)) - a.row(1).dot(b.row(0)));
  const bool is_determined = std::hypot(cosine, sine) > kCorrelationTolerance * Spread(from, a) * Spread(to, b) &&
                             Spread(from, a) > 0.0 && Spread(to, b) > 0.0;
  const SE2 rotation(0.0, 0.0, is_determined ? std::atan2(sine, cosine) : 0.0);
  const Eigen::Vector2d translation = to_mean - rotation * from_mean;
  return SE2(translation.x(), translation.y(), rotation.theta());
}

Eigen::Isometry3d UmeyamaSe3(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  CheckSizes(from, to);
  const Eigen::Vector3d from_mean = from.rowwise().mean();
  const Eigen::Vector3d to_mean = to.rowwise().mean();
  const Eigen::Matrix3Xd a = from.colwise() - from_mean;
  const Eigen::Matrix3Xd b = to.colwise() - to_mean;
  const double spread = Spread(from, a) * Spread(to, b);
  const Eigen::Matrix3d correlation = b * a.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& strength = svd.singularValues();
  const Eigen::Matrix3d& U = svd.matrixU();
  const Eigen::Matrix3d& V = svd.matrixV();

  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (spread > 0.0 && strength(0) > kCorrelationTolerance * spread) {
    if (strength(1) > kCorrelationTolerance * strength(0)) {
      Eigen::Vector3d sign(1.0, 1.0, 1.0);
      if (U.determinant() * V.determinant() < 0.0) sign.z() = -1.0;
      rotation = U * sign.asDiagonal() * V.transpose();
    } else {
      rotation = UprightFrame(U.col(0)) * UprightFrame(V.col(0)).transpose();
    }
  }
  Eigen::Isometry3d T_to_from = Eigen::Isometry3d::Identity();
  T_to_from.linear() = rotation;
  T_to_from.translation() = to_mean - rotation * from_mean;
  return T_to_from;
}

Eigen::Isometry3d Align(const std::vector<PosePair>& pairs, AlignmentKind kind) {
  if (pairs.empty()) throw std::invalid_argument("an alignment needs at least one pair of poses");
  Eigen::Matrix3Xd estimate(3, pairs.size());
  Eigen::Matrix3Xd reference(3, pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    estimate.col(column) = pairs[i].estimate.position;
    reference.col(column) = pairs[i].reference.position;
  }
  switch (kind) {
    case AlignmentKind::kNone:
      return Eigen::Isometry3d::Identity();
    case AlignmentKind::kOrigin:
      return ToIsometry(PlanarPose(pairs.front().reference) * PlanarPose(pairs.front().estimate).Inverse());
    case AlignmentKind::kSe2:
      return ToIsometry(UmeyamaSe2(estimate.topRows<2>(), reference.topRows<2>()));
    case AlignmentKind::kSe3:
      return UmeyamaSe3(estimate, reference);
  }
  throw std::invalid_argument("no such alignment");
}

StampedPose3 Transform(const Eigen::Isometry3d& T_reference_estimate, const StampedPose3& pose) {
  return {pose.stamp, T_reference_estimate * pose.position,
          (Eigen::Quaterniond(T_reference_estimate.linear()) * pose.orientation).normalized()};
}

}  // namespace arborslam
