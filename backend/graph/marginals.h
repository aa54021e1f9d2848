#ifndef ARBORSLAM_BACKEND_GRAPH_MARGINALS_H_
#define ARBORSLAM_BACKEND_GRAPH_MARGINALS_H_

#include <Eigen/Core>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "core/map/ids.h"

namespace arborslam {

/// Marginal covariances of nodes relative to the first keyframe, which is held: of (x, y, theta) [m, rad] as SE2 has
/// it, a perturbation in the node's own frame; at the graph's present poses, all constraints taken as independent. By
/// one sparse Cholesky factorisation and three solves a node. Infinite in all entries for a node that the constraints
/// do not tie to the first keyframe, and for all nodes when what ties them leaves a direction open.
///
/// @param nodes of the graph.
/// @return one matrix for each, in their order.
std::vector<Eigen::Matrix3d> MarginalCovariances(const PoseGraph& graph, const std::vector<NodeId>& nodes);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_MARGINALS_H_
