#include "core/sensor/trajectory3.h"

#include <cmath>

namespace arborslam {

Trajectory3 ToTrajectory3(const Trajectory& trajectory) {
  Trajectory3 lifted;
  lifted.poses.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    const Eigen::AngleAxisd yaw(pose.pose.theta(), Eigen::Vector3d::UnitZ());
    lifted.poses.push_back({pose.stamp, {pose.pose.x(), pose.pose.y(), 0.0}, Eigen::Quaterniond(yaw)});
  }
  return lifted;
}

StampedPose3 Lifted(const StampedPose& pose, const Tilt3& tilt) {
  const Eigen::Isometry3d T_map_lidar = Lift(pose.pose, tilt);
  return {pose.stamp, T_map_lidar.translation(), Eigen::Quaterniond(T_map_lidar.linear()).normalized()};
}

Trajectory ToPlanar(const Trajectory3& trajectory) {
  Trajectory planar;
  planar.reserve(trajectory.poses.size());
  for (const StampedPose3& pose : trajectory.poses) {
    const Eigen::Vector3d ahead = pose.orientation * Eigen::Vector3d::UnitX();
    planar.push_back({pose.stamp, SE2(pose.position.x(), pose.position.y(), std::atan2(ahead.y(), ahead.x()))});
  }
  return planar;
}

}  // namespace arborslam
