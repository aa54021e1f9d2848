#include "core/geometry/tilt.h"

#include <cmath>

namespace arborslam {

Eigen::Matrix3d Tilt3::Rotation() const {
  return (Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Isometry3d Tilt3::Transform() const {
  Eigen::Isometry3d T_base_lidar = Eigen::Isometry3d::Identity();
  T_base_lidar.linear() = Rotation();
  T_base_lidar.translation().z() = z;
  return T_base_lidar;
}

Tilt3 TiltOf(const Eigen::Matrix3d& rotation) { return TiltFromUp(rotation.row(2).transpose()); }

Tilt3 TiltFromUp(const Eigen::Vector3d& up) {
  // The last row of Ry(pitch) * Rx(roll) is (-sin pitch, cos pitch sin roll, cos pitch cos roll).
  Tilt3 tilt;
  tilt.roll = std::atan2(up.y(), up.z());
  tilt.pitch = std::atan2(-up.x(), std::hypot(up.y(), up.z()));
  return tilt;
}

Eigen::Isometry3d Lift(const SE2& T_map_base, const Tilt3& tilt) {
  Eigen::Isometry3d T_map_base3 = Eigen::Isometry3d::Identity();
  T_map_base3.linear() = Eigen::AngleAxisd(T_map_base.theta(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_map_base3.translation().head<2>() = T_map_base.translation();
  return T_map_base3 * tilt.Transform();
}

}  // namespace arborslam
