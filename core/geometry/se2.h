#ifndef ARBORSLAM_CORE_GEOMETRY_SE2_H_
#define ARBORSLAM_CORE_GEOMETRY_SE2_H_

#include <Eigen/Core>
#include <iosfwd>

namespace arborslam {

/// A rigid motion of the plane (paper eq. 3), as a value. `T_a_b` maps a point in frame b to frame a:
/// `p_a = T_a_b * p_b`; products chain as `T_a_c = T_a_b * T_b_c`. Lengths in metres, angles in radians.
///
/// Perturbations, covariances and information matrices of an SE2 are ordered (x, y, theta) and are expressed in the
/// *right* frame: `T_a_b` perturbed by (dx, dy, dtheta) is `T_a_b * SE2(dx, dy, dtheta)`.
class SE2 {
 public:
  /// The identity.
  SE2() = default;
  /// Translation (x, y) [m] and rotation theta [rad]; theta is kept in [-pi, pi).
  SE2(double x, double y, double theta);

  double x() const { return translation_.x(); }
  double y() const { return translation_.y(); }
  double theta() const { return theta_; }
  double cos() const { return cos_; }
  double sin() const { return sin_; }
  const Eigen::Vector2d& translation() const { return translation_; }
  Eigen::Matrix2d rotation() const;
  /// (x, y, theta).
  Eigen::Vector3d vector() const { return {x(), y(), theta_}; }

  SE2 Inverse() const;
  SE2 operator*(const SE2& other) const;
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const {
    return {cos_ * point.x() - sin_ * point.y() + x(), sin_ * point.x() + cos_ * point.y() + y()};
  }

  /// The 3x3 adjoint: `T * SE2(d) * T^-1` is, to first order, `SE2(Adjoint() * d)`.
  Eigen::Matrix3d Adjoint() const;

  /// True if translation and rotation agree with `other` within `tolerance` [m, rad].
  bool IsApprox(const SE2& other, double tolerance = 1e-9) const;

 private:
  Eigen::Vector2d translation_ = Eigen::Vector2d::Zero();
  double theta_ = 0.0;
  double cos_ = 1.0;
  double sin_ = 0.0;
};

/// True if two poses lie no more than `translation` [m] apart and are turned by no more than `rotation` [rad].
bool AreClose(const SE2& a, const SE2& b, double translation, double rotation);

/// The pose a fraction `t` in [0, 1] of the way from `a` to `b`: straight line, constant rotation rate.
SE2 Interpolate(const SE2& a, const SE2& b, double t);

/// Prints "(x, y, theta)".
std::ostream& operator<<(std::ostream& stream, const SE2& pose);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_GEOMETRY_SE2_H_
