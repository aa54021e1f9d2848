#ifndef ARBORSLAM_CORE_SENSOR_TRAJECTORY3_H_
#define ARBORSLAM_CORE_SENSOR_TRAJECTORY3_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "core/geometry/tilt.h"
#include "core/sensor/stamped_pose.h"

namespace arborslam {

/// A pose in space with the time it holds at.
struct StampedPose3 {
  double stamp = 0.0;                                               ///< [s], the middle of the sweep.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();               ///< Translation of T_map_base [m].
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< Rotation of T_map_base, of unit norm.
};

/// Poses in the order of their stamps, of an estimate or of a reference.
struct Trajectory3 {
  std::vector<StampedPose3> poses;
  /// False when only positions were measured (one GNSS antenna); the orientations are then the identity.
  bool has_orientation = true;
};

/// The planar poses lifted to z = 0 with yaw alone.
Trajectory3 ToTrajectory3(const Trajectory& trajectory);

/// The pose in space, T_map_lidar, of a planar one, T_map_base, with a lidar that has `tilt`.
StampedPose3 Lifted(const StampedPose& pose, const Tilt3& tilt);

/// The poses seen from above: x, y and the yaw of the base's x axis; 0 where there is no orientation.
Trajectory ToPlanar(const Trajectory3& trajectory);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_TRAJECTORY3_H_
