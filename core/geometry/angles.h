#ifndef ARBORSLAM_CORE_GEOMETRY_ANGLES_H_
#define ARBORSLAM_CORE_GEOMETRY_ANGLES_H_

#include <cmath>

namespace arborslam {

constexpr double kPi = 3.14159265358979323846;

/// `angle` [rad] wrapped to [-pi, pi); one that lies there already is returned as it is.
inline double NormalizeAngle(double angle) {
  if (angle >= -kPi && angle < kPi) return angle;
  const double wrapped = std::remainder(angle, 2.0 * kPi);  // In [-pi, pi].
  return wrapped == kPi ? -kPi : wrapped;
}

/// The signed rotation [rad] in [-pi, pi) that leads from `from` to `to`.
inline double AngleDifference(double to, double from) { return NormalizeAngle(to - from); }

/// Degrees to radians.
inline constexpr double DegToRad(double degrees) { return degrees * kPi / 180.0; }

/// Radians to degrees.
inline constexpr double RadToDeg(double radians) { return radians * 180.0 / kPi; }

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_GEOMETRY_ANGLES_H_
