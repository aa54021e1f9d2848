#ifndef ARBORSLAM_APPS_OFFLINE_CLOUD_H_
#define ARBORSLAM_APPS_OFFLINE_CLOUD_H_

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "backend/slam.h"
#include "core/io/scan_source.h"
#include "core/map/cloud_options.h"
#include "core/sensor/trajectory3.h"
#include "frontend/projection/deskew.h"

namespace arborslam {

/// How the lidar moved around pose `index` of `trajectory` (T_map_lidar), by the poses before and after it. Where these
/// are more than 0.15 s away it is taken to have moved level and turned about the vertical only: a stride is over by
/// then.
SweepMotion MotionAt(const Trajectory3& trajectory, size_t index);

/// True for a scan that the 3D map takes: with `every_nth_sweep` = 0 those of clean keyframes, else every so many of
/// the matched ones.
/// @param num_matched scans before it that were matched.
bool IsInCloud(const ScanResult& scan, size_t num_matched, const CloudOptions& options);

/// A 3D map.
struct Cloud {
  std::vector<Eigen::Vector3f> points;  ///< [m], map frame.
  size_t num_sweeps = 0;                ///< That it was made of.
  double voxel_size = 0.0;              ///< [m], above the one asked for if the map was too large.
  bool is_whole = true;                 ///< False: it was given up.
};

/// Makes the 3D map: reads a recording once more and places its sweeps, deskewed, at their final poses.
/// @param source     the recording, from its beginning.
/// @param scans      what became of its first scans, in their order; none beyond the last of these is read.
/// @param trajectory T_map_lidar of those of them that were not skipped.
/// @param deskew     whether the motion during a sweep is taken out.
/// @param go_on      called with the number of sweeps read so far; false: give up.
/// Throws `UserError` when the recording is damaged or is not that of `scans` (any more).
Cloud BuildCloud(ScanSource* source, const std::vector<ScanResult>& scans, const Trajectory3& trajectory,
                 const CloudOptions& options, bool deskew, const std::function<bool(size_t)>& go_on);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_CLOUD_H_
