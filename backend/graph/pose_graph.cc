#include "backend/graph/pose_graph.h"

#include <ceres/cost_function.h>
#include <glog/logging.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "backend/factors/relative_pose_factor.h"
#include "backend/graph/robust_minimum.h"
#include "backend/graph/robust_solver.h"
#include "core/config/validation.h"

namespace arborslam {
namespace {

constexpr double kFineTolerance = 1e-8;  // Of the last solve.

}  // namespace

std::string PoseGraphOptions::Validate() const {
  if (max_iterations < 1) return Violation("max_iterations", max_iterations, "be at least 1");
  if (!(loop_gate > 0.0)) return Violation("loop_gate", loop_gate, "be above 0");
  return "";
}

void PoseGraph::AddNode(NodeId id, const SE2& T_map_node) {
  CHECK(poses_.emplace(id, T_map_node).second) << id << " is in the graph already";
}

void PoseGraph::AddConstraint(const Constraint& constraint) {
  CHECK(poses_.count(constraint.from) > 0 && poses_.count(constraint.to) > 0)
      << constraint.from << " to " << constraint.to;
  CHECK(constraint.information.allFinite() && constraint.T_from_to.vector().allFinite())
      << constraint.from << " to " << constraint.to << " is not finite";
  constraints_.push_back(constraint);
}

std::vector<Constraint> PoseGraph::Remove(const std::function<bool(const Constraint&)>& is_wrong) {
  const auto first_wrong = std::stable_partition(constraints_.begin(), constraints_.end(),
                                                 [&](const Constraint& constraint) { return !is_wrong(constraint); });
  std::vector<Constraint> removed(first_wrong, constraints_.end());
  constraints_.erase(first_wrong, constraints_.end());
  return removed;
}

PoseGraphSummary PoseGraph::Optimize(const PoseGraphOptions& options, int num_threads) {
  PoseGraphSummary summary;
  if (poses_.empty()) return summary;
  // Ids sort keyframes first: the first keyframe is the first pose, which the solver holds.
  std::vector<Eigen::Vector3d> poses;
  std::map<NodeId, size_t> index;
  for (const auto& [id, pose] : poses_) {
    index.emplace(id, poses.size());
    poses.push_back(pose.vector());
  }
  std::vector<GraphEdge> edges;
  edges.reserve(constraints_.size());
  bool has_loops = false;
  for (const Constraint& constraint : constraints_) {
    const bool is_loop = constraint.kind == Constraint::Kind::kLoop;
    has_loops |= is_loop;
    edges.push_back(
        {index.at(constraint.from), index.at(constraint.to),
         std::shared_ptr<ceres::CostFunction>(CreateRelativePoseFactor(constraint.T_from_to, constraint.information)),
         is_loop});
  }

  const std::vector<Eigen::Vector3d> initial = poses;
  if (has_loops) {
    RobustMinimum minimum = FindRobustMinimum(initial, initial, edges, {0}, options.loop_gate, num_threads);
    poses = std::move(minimum.poses);
    summary.iterations = minimum.iterations;
    std::vector<Constraint> kept_constraints;
    std::vector<GraphEdge> kept_edges;
    for (size_t i = 0; i < edges.size(); ++i) {
      if (edges[i].may_be_wrong && ErrorOf(edges[i], poses) > options.loop_gate) {
        summary.dropped_loops.push_back(constraints_[i]);
      } else {
        kept_constraints.push_back(constraints_[i]);
        kept_edges.push_back(edges[i]);
      }
    }
    constraints_ = std::move(kept_constraints);
    edges = std::move(kept_edges);
  }

  summary.initial_cost = CostOf(edges, initial, options.loop_gate);
  RobustSolver last(poses, edges);
  last.Solve(options.loop_gate, options.max_iterations, kFineTolerance);
  summary.final_cost = last.final_cost();
  summary.iterations += last.iterations();
  auto solved = last.poses().begin();
  for (auto& [id, pose] : poses_) {
    pose = SE2(solved->x(), solved->y(), solved->z());
    ++solved;
  }
  return summary;
}

}  // namespace arborslam
