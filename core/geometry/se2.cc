#include "core/geometry/se2.h"

#include <cmath>
#include <ostream>

#include "core/geometry/angles.h"

namespace arborslam {

SE2::SE2(double x, double y, double theta)
    : translation_(x, y), theta_(NormalizeAngle(theta)), cos_(std::cos(theta_)), sin_(std::sin(theta_)) {}

Eigen::Matrix2d SE2::rotation() const { return (Eigen::Matrix2d() << cos_, -sin_, sin_, cos_).finished(); }

SE2 SE2::Inverse() const { return SE2(-cos_ * x() - sin_ * y(), sin_ * x() - cos_ * y(), -theta_); }

SE2 SE2::operator*(const SE2& other) const {
  const Eigen::Vector2d translation = *this * other.translation_;
  return SE2(translation.x(), translation.y(), theta_ + other.theta_);
}

Eigen::Matrix3d SE2::Adjoint() const {
  return (Eigen::Matrix3d() << cos_, -sin_, y(), sin_, cos_, -x(), 0.0, 0.0, 1.0).finished();
}

bool SE2::IsApprox(const SE2& other, double tolerance) const {
  return (translation_ - other.translation_).norm() <= tolerance &&
         std::abs(AngleDifference(theta_, other.theta_)) <= tolerance;
}

bool AreClose(const SE2& a, const SE2& b, double translation, double rotation) {
  return (a.translation() - b.translation()).norm() <= translation &&
         std::abs(AngleDifference(a.theta(), b.theta())) <= rotation;
}

SE2 Interpolate(const SE2& a, const SE2& b, double t) {
  const Eigen::Vector2d translation = (1.0 - t) * a.translation() + t * b.translation();
  return SE2(translation.x(), translation.y(), a.theta() + t * AngleDifference(b.theta(), a.theta()));
}

std::ostream& operator<<(std::ostream& stream, const SE2& pose) {
  return stream << "(" << pose.x() << ", " << pose.y() << ", " << pose.theta() << ")";
}

}  // namespace arborslam
