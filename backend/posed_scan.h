#ifndef ARBORSLAM_BACKEND_POSED_SCAN_H_
#define ARBORSLAM_BACKEND_POSED_SCAN_H_

#include <vector>

#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "core/io/value_store.h"
#include "core/map/ids.h"
#include "core/sensor/ground_sample.h"
#include "frontend/projection/upright_lines.h"

namespace arborslam {

/// A scan that has a pose: it hangs on the keyframe at or before it.
struct PosedScan {
  double stamp = 0.0;  ///< [s], the middle of the sweep.
  KeyframeId keyframe;
  SE2 T_keyframe_scan;
  // Of sweeps in space; 0 and empty for planar scans.
  Tilt3 tilt;                                ///< Over the map's level.
  Tilt3 local_tilt;                          ///< Over the slope of the ground around the robot.
  Stored<std::vector<GroundSample>> ground;  ///< In the lidar frame.
  Tilt3 odometry_tilt;                       ///< `tilt` when the sweep came, with which `lines` were measured.
  Stored<std::vector<UprightLine>> lines;    ///< Of keyframes.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(stamp, keyframe, T_keyframe_scan, tilt, local_tilt, ground, odometry_tilt, lines);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_POSED_SCAN_H_
