#ifndef ARBORSLAM_BACKEND_RUN_OUTPUTS_H_
#define ARBORSLAM_BACKEND_RUN_OUTPUTS_H_

#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/posed_scan.h"
#include "backend/store/session_contents.h"
#include "core/map/occupancy_grid.h"
#include "core/sensor/stamped_pose.h"
#include "core/sensor/trajectory3.h"

namespace arborslam {

/// T_map_base of `scans`, whose keyframes are in `graph`.
Trajectory TrajectoryOf(const PoseGraph& graph, const std::vector<PosedScan>& scans);

/// The same in space, T_map_lidar.
Trajectory3 Trajectory3Of(const PoseGraph& graph, const std::vector<PosedScan>& scans);

/// The same of each recording of a session, in their order.
std::vector<Trajectory3> TrajectoriesOf(const SessionContents& session);

/// All clean scans of `keyframes` of the graph's main part (`MapParts`) at their poses, in the map frame.
OccupancyGrid MapOf(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                    const OccupancyGridOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_RUN_OUTPUTS_H_
