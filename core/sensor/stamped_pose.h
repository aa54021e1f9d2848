#ifndef ARBORSLAM_CORE_SENSOR_STAMPED_POSE_H_
#define ARBORSLAM_CORE_SENSOR_STAMPED_POSE_H_

#include <vector>

#include "core/geometry/se2.h"

namespace arborslam {

/// A pose with the time it holds at.
struct StampedPose {
  double stamp = 0.0;  ///< [s], the middle of the sweep that the pose belongs to.
  SE2 pose;            ///< T_map_base [m, rad].
};

/// Poses in the order of their stamps.
using Trajectory = std::vector<StampedPose>;

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_STAMPED_POSE_H_
