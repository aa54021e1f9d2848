#include "backend/graph/overlap_discount.h"

#include <cstddef>
#include <map>
#include <vector>

namespace arborslam {
namespace {

// Of each keyframe, how many lie on the path within half of `length` [m] to either side, itself included.
std::map<NodeId, double> CountNeighbours(const PoseGraph& graph, double length) {
  std::vector<NodeId> keyframes;
  std::vector<double> way;
  for (const auto& [id, pose] : graph.poses()) {
    if (id.kind != NodeId::Kind::kKeyframe) continue;
    const double step =
        keyframes.empty() ? 0.0 : (pose.translation() - graph.Pose(keyframes.back()).translation()).norm();
    way.push_back(way.empty() ? 0.0 : way.back() + step);
    keyframes.push_back(id);
  }
  std::map<NodeId, double> counts;
  size_t first = 0;
  size_t end = 0;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    while (way[first] < way[i] - 0.5 * length) ++first;
    while (end < way.size() && way[end] <= way[i] + 0.5 * length) ++end;
    counts[keyframes[i]] = static_cast<double>(end - first);
  }
  return counts;
}

}  // namespace

PoseGraph DiscountOverlap(const PoseGraph& graph, double correlation_length) {
  std::map<NodeId, double> num_matches;
  for (const Constraint& constraint : graph.constraints()) {
    if (IsMatch(constraint)) num_matches[constraint.to] += 1.0;
  }
  const std::map<NodeId, double> num_neighbours = CountNeighbours(graph, correlation_length);
  PoseGraph discounted;
  for (const auto& [id, pose] : graph.poses()) discounted.AddNode(id, pose);
  for (Constraint constraint : graph.constraints()) {
    const auto neighbours = num_neighbours.find(constraint.to);
    if (IsMatch(constraint) && neighbours != num_neighbours.end()) {
      constraint.information /= num_matches[constraint.to] * neighbours->second;
    }
    discounted.AddConstraint(constraint);
  }
  return discounted;
}

}  // namespace arborslam
