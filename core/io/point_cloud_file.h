#ifndef ARBORSLAM_CORE_IO_POINT_CLOUD_FILE_H_
#define ARBORSLAM_CORE_IO_POINT_CLOUD_FILE_H_

#include <string>
#include <vector>

#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// What a point cloud file holds of a sweep.
struct PointCloudFile {
  LidarSweep sweep;               ///< Its points; stamp, duration and times are left to whom the recording is known.
  std::string time_field;         ///< The field that the times come from; "" when there is none.
  std::vector<double> raw_times;  ///< The points' times as they stand there, finite, one a point; or none at all.
};

/// Reads a PCD file (text, binary, compressed) or a PLY file (text, binary of either byte order; its vertices), told
/// apart by their beginning. Coordinates are the fields x, y, z [m], float or double. Times are the first of the fields
/// time, t, timestamp, time_stamp, offset_time that there is, of any type; see `FindPointTimeFormat` for what they
/// mean. Other fields are left aside, and so is the PCD's viewpoint.
///
/// Points that are infinite, not a number or at the origin are dropped, and those whose time is not finite, unless
/// that is so for most: then there are no times.
///
/// The file is not trusted, see `ParseCloudHeader`. Throws `UserError` naming it when it cannot be read, is damaged,
/// has no coordinates, or does not have as many points as it claims.
PointCloudFile ReadPointCloudFile(const std::string& path);

/// Writes `sweep` as a binary PCD file: x, y, z and, when the sweep has times, `time`, seconds since its start; all
/// float32. Throws `UserError` when the file cannot be written.
void WritePcd(const std::string& path, const LidarSweep& sweep);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_POINT_CLOUD_FILE_H_
