#include "backend/graph/pose_graph.h"

#include <ceres/cost_function.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "backend/factors/relative_pose_factor.h"
#include "backend/graph/robust_solver.h"
#include "core/config/validation.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// Of the last solve, and of those on the way. Growing goes on while few loops at a time come to fit.
constexpr double kFineTolerance = 1e-8;
constexpr double kGrowingTolerance = 1e-5;
constexpr double kShrinkingTolerance = 1e-3;
constexpr int kCoarseIterations = 20;
// How much one solve's scale differs from that of the one before. Few and large steps of shrinking do (Yang et al. take
// 1.4): what a solve costs is less its iterations than Ceres' analysis of the graph.
constexpr double kGrowth = 4.0;
constexpr double kShrinkage = 16.0;

double LargestLoopError(const RobustSolver& solver, const std::vector<GraphEdge>& edges) {
  double largest = 0.0;
  for (const GraphEdge& edge : edges) {
    if (edge.may_be_wrong) largest = std::max(largest, ErrorOf(edge, solver.poses()));
  }
  return largest;
}

void SolveGrowing(double gate, RobustSolver* solver) {
  solver->Solve(gate / kGrowth, kCoarseIterations, kGrowingTolerance);
  solver->Solve(gate, kCoarseIterations, kGrowingTolerance);
}

void SolveShrinking(double gate, const std::vector<GraphEdge>& edges, RobustSolver* solver) {
  // At sqrt(2) times the largest error, the cost of all loops is nearly quadratic (Yang et al. 2020, remark 5).
  double scale = std::sqrt(2.0) * LargestLoopError(*solver, edges);
  while (scale > gate) {
    solver->Solve(scale, 1, kShrinkingTolerance);
    scale = std::min(scale / kShrinkage, std::sqrt(2.0) * LargestLoopError(*solver, edges));
  }
  solver->Solve(gate, kCoarseIterations, kShrinkingTolerance);
}

// The lower of the two minima of `PoseGraph::Optimize`.
struct RobustMinimum {
  std::vector<Eigen::Vector3d> poses;
  int iterations = 0;
};

RobustMinimum FindRobustMinimum(const std::vector<Eigen::Vector3d>& initial, const std::vector<GraphEdge>& edges,
                                double gate, int num_threads) {
  std::optional<RobustSolver> growing;
  std::optional<RobustSolver> shrinking;
  const auto grow = [&] { SolveGrowing(gate, &growing.emplace(initial, edges)); };
  const auto shrink = [&] { SolveShrinking(gate, edges, &shrinking.emplace(initial, edges)); };
  const auto all_fit = [&] { return LargestLoopError(*growing, edges) <= gate; };
  if (num_threads < 2) {
    grow();
    if (!all_fit()) shrink();
  } else {
    ParallelFor(2, 2, [&](size_t i) { i == 0 ? grow() : shrink(); });
  }
  if (all_fit()) return {growing->poses(), growing->iterations()};
  const RobustSolver& lower = shrinking->final_cost() < growing->final_cost() ? *shrinking : *growing;
  return {lower.poses(), growing->iterations() + shrinking->iterations()};
}

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
    RobustMinimum minimum = FindRobustMinimum(initial, edges, options.loop_gate, num_threads);
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
