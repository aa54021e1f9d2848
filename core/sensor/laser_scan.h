#ifndef ARBORSLAM_CORE_SENSOR_LASER_SCAN_H_
#define ARBORSLAM_CORE_SENSOR_LASER_SCAN_H_

#include <vector>

namespace arborslam {

/// One revolution (or sector) of a planar lidar, in its own frame: x ahead, y left, bearings counter-clockwise.
struct LaserScan {
  double stamp = 0.0;              ///< [s], the middle of the sweep.
  double bearing_min = 0.0;        ///< [rad], bearing of ranges[0].
  double bearing_increment = 0.0;  ///< [rad] between neighbouring beams.
  std::vector<float> ranges;       ///< [m], one per beam; infinite or NaN where nothing came back.

  double Bearing(size_t beam) const { return bearing_min + bearing_increment * static_cast<double>(beam); }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_LASER_SCAN_H_
