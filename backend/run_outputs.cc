#include "backend/run_outputs.h"

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

OccupancyGrid MapOf(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                    const OccupancyGridOptions& options) {
  OccupancyGrid map(options);
  for (const Keyframe& keyframe : keyframes) {
    if (keyframe.is_inserted) map.Insert(graph.Pose(keyframe.id), keyframe.scan);
  }
  return map;
}

}  // namespace arborslam
