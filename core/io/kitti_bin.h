#ifndef ARBORSLAM_CORE_IO_KITTI_BIN_H_
#define ARBORSLAM_CORE_IO_KITTI_BIN_H_

#include <string>

#include "core/io/bin_layout.h"
#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// Reads a sweep of the KITTI data sets (Geiger et al. 2013): for each point x, y, z [m] and intensity, four
/// little-endian float32, and nothing else. Stamp and duration are not in it and stay 0, and there are no point times.
/// A file of no bytes is a sweep without points. Throws `UserError` when the file cannot be read, is not a whole number
/// of points long, or holds more than `kMaxSweepPoints`.
LidarSweep ReadKittiBin(const std::string& path, const BinLayout& layout = {});

/// Writes the points of `sweep` with intensity 0. Throws `UserError` when the file cannot be written.
void WriteKittiBin(const std::string& path, const LidarSweep& sweep);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_KITTI_BIN_H_
