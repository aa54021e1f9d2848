#include "apps/offline/cloud.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <string>
#include <variant>

#include "core/error.h"
#include "core/map/voxel_map.h"
#include "frontend/projection/sweep_timing.h"

namespace arborslam {
namespace {

constexpr double kMaxStep = 0.15;  // [s], between poses that tell how the lidar rocked.

struct PlacedSweep {
  size_t scan;  // Index into the scans,
  size_t pose;  // and into the poses.
};

std::vector<PlacedSweep> ChooseSweeps(const std::vector<ScanResult>& scans, const CloudOptions& options) {
  std::vector<PlacedSweep> chosen;
  size_t num_posed = 0;
  size_t num_matched = 0;
  for (size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].status == ScanStatus::kSkipped) continue;
    if (IsInCloud(scans[i], num_matched, options)) chosen.push_back({i, num_posed});
    ++num_posed;
    num_matched += scans[i].status == ScanStatus::kMatched ? 1 : 0;
  }
  return chosen;
}

// The points within range, in the map frame.
void Place(const std::vector<Eigen::Vector3f>& points, const StampedPose3& pose, const CloudOptions& options,
           std::vector<Eigen::Vector3f>* placed) {
  const Eigen::Matrix3f R_map_lidar = pose.orientation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f origin = pose.position.cast<float>();
  const auto least = static_cast<float>(options.min_range * options.min_range);
  const auto most = static_cast<float>(options.max_range * options.max_range);
  placed->clear();
  for (const Eigen::Vector3f& point : points) {
    const float range_squared = point.squaredNorm();
    if (range_squared >= least && range_squared <= most) placed->push_back(R_map_lidar * point + origin);
  }
}

}  // namespace

SweepMotion MotionAt(const Trajectory3& trajectory, size_t index) {
  const std::vector<StampedPose3>& poses = trajectory.poses;
  CHECK_LT(index, poses.size());
  const StampedPose3& at = poses[index];
  const StampedPose3& before = poses[index == 0 ? 0 : index - 1];
  const StampedPose3& after = poses[std::min(index + 1, poses.size() - 1)];
  const double duration = after.stamp - before.stamp;
  if (!(duration > 0.0)) return {};
  Eigen::Vector3d velocity = (after.position - before.position) / duration;
  const Eigen::AngleAxisd turn(after.orientation * before.orientation.conjugate());
  Eigen::Vector3d angular_velocity = turn.angle() / duration * turn.axis();
  if (std::max(at.stamp - before.stamp, after.stamp - at.stamp) > kMaxStep) {
    velocity.z() = 0.0;
    angular_velocity.head<2>().setZero();
  }
  const Eigen::Quaterniond R_lidar_map = at.orientation.conjugate();
  return {(R_lidar_map * velocity).cast<float>(), (R_lidar_map * angular_velocity).cast<float>()};
}

bool IsInCloud(const ScanResult& scan, size_t num_matched, const CloudOptions& options) {
  if (scan.status != ScanStatus::kMatched) return false;
  if (options.every_nth_sweep == 0) return scan.is_keyframe && scan.is_inserted;
  return num_matched % static_cast<size_t>(options.every_nth_sweep) == 0;
}

Cloud BuildCloud(ScanSource* source, const std::vector<ScanResult>& scans, const Trajectory3& trajectory,
                 const CloudOptions& options, bool deskew, const std::function<bool(size_t)>& go_on) {
  VoxelMap map(options.voxel_size, static_cast<size_t>(options.max_voxels));
  std::vector<float> phases;
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> placed;
  Cloud cloud;
  size_t num_read = 0;
  for (const PlacedSweep& chosen : ChooseSweeps(scans, options)) {
    std::optional<Scan> scan;
    while (num_read <= chosen.scan) {
      if (!go_on(num_read)) {
        cloud.is_whole = false;
        return cloud;
      }
      scan = source->Next();
      ++num_read;
      if (!scan) break;
    }
    const LidarSweep* sweep = scan ? std::get_if<LidarSweep>(&*scan) : nullptr;
    if (sweep == nullptr || sweep->Middle() != scans[chosen.scan].stamp) {
      throw UserError("sweep " + std::to_string(chosen.scan), "is not the one that was read before",
                      "leave the recording alone while it is processed");
    }
    phases.clear();
    if (deskew) PointPhases(*sweep, &phases);
    Deskew(*sweep, phases, MotionAt(trajectory, chosen.pose), &points);
    Place(points, trajectory.poses.at(chosen.pose), options, &placed);
    map.AddSweep(placed);
    ++cloud.num_sweeps;
  }
  cloud.points = map.Points(options.min_sweeps);
  cloud.voxel_size = map.voxel_size();
  return cloud;
}

}  // namespace arborslam
