#ifndef ARBORSLAM_CORE_IO_SWEEP_POINTS_H_
#define ARBORSLAM_CORE_IO_SWEEP_POINTS_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// More points than any lidar measures in a revolution: a file that claims more is a map or damaged.
constexpr size_t kMaxSweepPoints = size_t{1} << 24;

/// Appends the point (x, y, z) [m] to `sweep`, or counts it as dropped when it is infinite, not a number, or at the
/// origin, where drivers put beams without a return. Says whether it was appended.
bool AppendPoint(float x, float y, float z, LidarSweep* sweep);

/// Throws the `UserError` about `path` that claims `count` points when they are more than `kMaxSweepPoints`.
void RequireSweepSize(const std::string& path, uint64_t count);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SWEEP_POINTS_H_
