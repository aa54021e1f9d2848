#ifndef ARBORSLAM_APPS_OFFLINE_GRAPH_EXPORT_H_
#define ARBORSLAM_APPS_OFFLINE_GRAPH_EXPORT_H_

#include "backend/graph/pose_graph.h"
#include "core/io/g2o.h"

namespace arborslam {

/// The graph for other programs: keyframes keep their numbers, submaps follow them.
PoseGraph2 ToG2o(const PoseGraph& graph);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_GRAPH_EXPORT_H_
