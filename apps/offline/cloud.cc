#include "apps/offline/cloud.h"

#include <Eigen/Geometry>

#include "frontend/projection/deskew.h"
#include "frontend/projection/sweep_timing.h"

namespace arborslam {

Cloud::Cloud(const CloudOptions& options, bool deskew)
    : options_(options), deskew_(deskew), map_(options.voxel_size, static_cast<size_t>(options.max_voxels)) {}

void Cloud::Add(const PosedSweep& sweep) {
  const auto nth = static_cast<size_t>(options_.every_nth_sweep);
  if (nth == 0 ? !sweep.result.is_inserted : sweep.num_matched % nth != 0) return;
  phases_.clear();
  if (deskew_) PointPhases(sweep.sweep, &phases_);
  Deskew(sweep.sweep, phases_, sweep.motion, &points_);
  const Eigen::Matrix3f R_map_lidar = sweep.pose.orientation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f origin = sweep.pose.position.cast<float>();
  const auto least = static_cast<float>(options_.min_range * options_.min_range);
  const auto most = static_cast<float>(options_.max_range * options_.max_range);
  size_t num_kept = 0;
  for (const Eigen::Vector3f& point : points_) {
    const float range_squared = point.squaredNorm();
    if (range_squared < least || range_squared > most) continue;
    points_[num_kept++] = R_map_lidar * point + origin;
  }
  points_.resize(num_kept);
  map_.AddSweep(points_);
  ++num_sweeps_;
}

}  // namespace arborslam
