#ifndef ARBORSLAM_APPS_OFFLINE_GRAPH_PICTURE_H_
#define ARBORSLAM_APPS_OFFLINE_GRAPH_PICTURE_H_

#include <vector>

#include "core/io/g2o.h"
#include "core/io/png.h"

namespace arborslam {

/// A pose graph from above, x to the right, y up: edges between vertices that follow each other in the order of ids
/// blue, loops grey, `dropped` ones red below all others, vertices `held` green. The graph must have a vertex, and
/// `dropped` and `held` name its vertices.
RgbImage DrawGraph(const PoseGraph2& graph, const std::vector<PoseGraph2::Edge>& dropped, const std::vector<int>& held);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_GRAPH_PICTURE_H_
