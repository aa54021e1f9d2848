#ifndef ARBORSLAM_CORE_SENSOR_LASER_SCAN_H_
#define ARBORSLAM_CORE_SENSOR_LASER_SCAN_H_

#include <optional>
#include <vector>

#include "core/geometry/se2.h"

namespace arborslam {

/// One revolution (or sector) of a planar lidar, in its own frame: x ahead, y left, bearings counter-clockwise.
struct LaserScan {
  double stamp = 0.0;              ///< [s], the middle of the sweep.
  double bearing_min = 0.0;        ///< [rad], bearing of ranges[0].
  double bearing_increment = 0.0;  ///< [rad] between neighbouring beams.
  std::vector<float> ranges;       ///< [m], one per beam; infinite or NaN where nothing came back.
  /// Where the wheels say the lidar is, T_wheels_lidar, in a frame of their own that drifts: only the motion from scan
  /// to scan means something. Nothing when the recording has no wheel odometry.
  std::optional<SE2> odometry;

  double Bearing(size_t beam) const { return bearing_min + bearing_increment * static_cast<double>(beam); }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_LASER_SCAN_H_
