#include "backend/run_outputs.h"

#include <cstddef>

#include "backend/graph/map_parts.h"
#include "core/geometry/tilt.h"

namespace arborslam {

Trajectory TrajectoryOf(const PoseGraph& graph, const std::vector<PosedScan>& scans) {
  Trajectory trajectory;
  trajectory.reserve(scans.size());
  for (const PosedScan& scan : scans) {
    trajectory.push_back({scan.stamp, graph.Pose(scan.keyframe) * scan.T_keyframe_scan});
  }
  return trajectory;
}

Trajectory3 Trajectory3Of(const PoseGraph& graph, const std::vector<PosedScan>& scans) {
  Trajectory3 trajectory;
  for (const PosedScan& scan : scans) {
    trajectory.poses.push_back(Lifted({scan.stamp, graph.Pose(scan.keyframe) * scan.T_keyframe_scan}, scan.tilt));
  }
  return trajectory;
}

std::vector<Trajectory3> TrajectoriesOf(const SessionContents& session) {
  const Trajectory3 all = Trajectory3Of(session.graph, session.scans);
  std::vector<Trajectory3> trajectories;
  auto begin = all.poses.begin();
  for (const SessionContents::Recording& recording : session.recordings) {
    const auto end = begin + static_cast<std::ptrdiff_t>(recording.num_posed);
    trajectories.emplace_back();
    trajectories.back().poses.assign(begin, end);
    begin = end;
  }
  return trajectories;
}

OccupancyGrid MapOf(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                    const OccupancyGridOptions& options) {
  OccupancyGrid map(options);
  const MapParts parts(graph);
  for (const Keyframe& keyframe : keyframes) {
    const bool is_placed = parts.num_parts() == 1 || parts.Of(keyframe.id) == parts.main_part();
    if (keyframe.is_inserted && is_placed) map.Insert(graph.Pose(keyframe.id), *keyframe.scan.Get());
  }
  return map;
}

}  // namespace arborslam
