#ifndef ARBORSLAM_APPS_OFFLINE_SECOND_PASS_H_
#define ARBORSLAM_APPS_OFFLINE_SECOND_PASS_H_

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "backend/slam.h"
#include "core/io/scan_source.h"
#include "core/sensor/lidar_sweep.h"
#include "core/sensor/trajectory3.h"
#include "frontend/projection/deskew.h"

namespace arborslam {

/// How the lidar moved around pose `index` of `trajectory` (T_map_lidar), by the poses before and after it. Where these
/// are more than 0.15 s away it is taken to have moved level and turned about the vertical only: a stride is over by
/// then.
SweepMotion MotionAt(const Trajectory3& trajectory, size_t index);

/// A sweep whose final pose is known.
struct PosedSweep {
  const LidarSweep& sweep;
  const ScanResult& result;  ///< When it came.
  size_t num_matched;        ///< Sweeps before it that were matched.
  SweepMotion motion;        ///< During the sweep.
  StampedPose3 pose;         ///< T_map_lidar.
};

/// Reads a recording of sweeps once more, to make maps that need more than the estimation keeps.
/// @param source     the recording, from its beginning.
/// @param scans      what became of its first scans, in their order.
/// @param duration   what was found about how long the sweeps last, by which they and the stamps of `scans` go.
/// @param trajectory T_map_lidar of those of them that were not skipped.
/// @param visit      called for every sweep that was matched, in order.
/// @param go_on      called with the number of sweeps read so far; false: stop.
/// Returns whether it came to the end of `scans`. Throws `UserError` when the recording is damaged or is not that of
/// `scans` (any more).
bool VisitMatchedSweeps(ScanSource* source, const std::vector<ScanResult>& scans,
                        const std::optional<SweepDurationResult>& duration, const Trajectory3& trajectory,
                        const std::function<void(const PosedSweep&)>& visit, const std::function<bool(size_t)>& go_on);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_SECOND_PASS_H_
