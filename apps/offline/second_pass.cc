#include "apps/offline/second_pass.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <variant>

#include "core/error.h"

namespace arborslam {
namespace {

constexpr double kMaxStep = 0.15;  // [s], between poses that tell how the lidar rocked.

// [s], beyond what rounding does to the stamp of a sweep.
constexpr double kStampTolerance = 1e-6;

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

bool VisitMatchedSweeps(ScanSource* source, const std::vector<ScanResult>& scans,
                        const std::optional<SweepDurationResult>& duration, const Trajectory3& trajectory,
                        const std::function<void(const PosedSweep&)>& visit, const std::function<bool(size_t)>& go_on) {
  size_t num_posed = 0;
  size_t num_matched = 0;
  for (size_t i = 0; i < scans.size(); ++i) {
    if (!go_on(i)) return false;
    std::optional<Scan> scan = source->Next();
    LidarSweep* sweep = scan ? std::get_if<LidarSweep>(&*scan) : nullptr;
    if (sweep != nullptr && duration && sweep->is_duration_guessed) {
      sweep->start = sweep->Middle() + duration->stamp_shift - 0.5 * duration->seconds;
      sweep->duration = duration->seconds;
    }
    if (sweep == nullptr || std::abs(sweep->Middle() - scans[i].stamp) > kStampTolerance) {
      throw UserError("sweep " + std::to_string(i), "is not the one that was read before",
                      "leave the recording alone while it is processed");
    }
    if (scans[i].status == ScanStatus::kSkipped) continue;
    if (scans[i].status == ScanStatus::kMatched) {
      visit({*sweep, scans[i], num_matched, MotionAt(trajectory, num_posed), trajectory.poses.at(num_posed)});
      ++num_matched;
    }
    ++num_posed;
  }
  return true;
}

}  // namespace arborslam
