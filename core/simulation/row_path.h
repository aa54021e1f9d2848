#ifndef ARBORSLAM_CORE_SIMULATION_ROW_PATH_H_
#define ARBORSLAM_CORE_SIMULATION_ROW_PATH_H_

#include <vector>

#include "core/simulation/closed_path.h"

namespace arborslam {

/// The closed path along lanes between rows of plants: lane k runs along x at y = k * spacing, from `near` to `far` [m]
/// in x. It begins in the origin, which must lie in between, goes along `lanes[0]` = 0 towards +x, comes back along the
/// next lane, and so on; an even number of lanes.
ClosedPath RowPath(const std::vector<int>& lanes, double spacing, double near, double far, double turn_radius);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_ROW_PATH_H_
