#include "apps/offline/graph_export.h"

#include <algorithm>

namespace arborslam {

PoseGraph2 ToG2o(const PoseGraph& graph) {
  int num_keyframes = 0;
  for (const auto& [id, pose] : graph.poses()) {
    if (id.kind == NodeId::Kind::kKeyframe) num_keyframes = std::max(num_keyframes, id.value + 1);
  }
  const auto number = [num_keyframes](NodeId id) {
    return id.kind == NodeId::Kind::kKeyframe ? id.value : num_keyframes + id.value;
  };
  // What a degenerate measurement does not say, g2o must be told very weakly: it wants positive definite matrices.
  const Eigen::Matrix3d least = 1e-6 * Eigen::Matrix3d::Identity();
  PoseGraph2 exported;
  for (const auto& [id, pose] : graph.poses()) exported.vertices[number(id)] = pose;
  for (const Constraint& constraint : graph.constraints()) {
    exported.edges.push_back(
        {number(constraint.from), number(constraint.to), constraint.T_from_to, constraint.information + least});
  }
  return exported;
}

}  // namespace arborslam
