#include "backend/graph/pose_graph.h"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>

#include "backend/factors/relative_pose_factor.h"
#include "core/config/validation.h"

namespace arborslam {

std::string PoseGraphOptions::Validate() const {
  if (max_iterations < 1) return Violation("max_iterations", max_iterations, "be at least 1");
  if (!(loop_loss_scale > 0.0)) return Violation("loop_loss_scale", loop_loss_scale, "be above 0");
  if (!(loop_gate > 0.0)) return Violation("loop_gate", loop_gate, "be above 0");
  return "";
}

void PoseGraph::AddNode(NodeId id, const SE2& T_map_node) {
  CHECK(poses_.emplace(id, T_map_node).second) << id << " is in the graph already";
}

void PoseGraph::AddConstraint(const Constraint& constraint) {
  CHECK(poses_.count(constraint.from) > 0 && poses_.count(constraint.to) > 0)
      << constraint.from << " to " << constraint.to;
  constraints_.push_back(constraint);
}

PoseGraphSummary PoseGraph::Optimize(const PoseGraphOptions& options, int num_threads) {
  PoseGraphSummary summary = Solve(options, num_threads);
  const auto agrees = [&](const Constraint& constraint) {
    if (constraint.kind != Constraint::Kind::kLoop) return true;
    const SE2 T_from_to = poses_.at(constraint.from).Inverse() * poses_.at(constraint.to);
    const Eigen::Vector3d error = (constraint.T_from_to.Inverse() * T_from_to).vector();
    return error.dot(constraint.information * error) <= options.loop_gate * options.loop_gate * 3.0;
  };
  const auto disagreeing = std::stable_partition(constraints_.begin(), constraints_.end(), agrees);
  summary.num_loops_dropped = static_cast<int>(constraints_.end() - disagreeing);
  if (summary.num_loops_dropped == 0) return summary;
  constraints_.erase(disagreeing, constraints_.end());
  const PoseGraphSummary again = Solve(options, num_threads);
  summary.final_cost = again.final_cost;
  summary.iterations += again.iterations;
  return summary;
}

PoseGraphSummary PoseGraph::Solve(const PoseGraphOptions& options, int num_threads) {
  PoseGraphSummary result;
  if (poses_.empty()) return result;
  std::map<NodeId, Eigen::Vector3d> blocks;
  ceres::Problem problem;
  for (const auto& [id, pose] : poses_) {
    Eigen::Vector3d& block = blocks[id] = pose.vector();
    problem.AddParameterBlock(block.data(), 3);
  }
  // Ids sort keyframes first: the first keyframe defines the map frame.
  problem.SetParameterBlockConstant(blocks.begin()->second.data());
  for (const Constraint& constraint : constraints_) {
    ceres::LossFunction* loss =
        constraint.kind == Constraint::Kind::kLoop ? new ceres::CauchyLoss(options.loop_loss_scale) : nullptr;
    problem.AddResidualBlock(CreateRelativePoseFactor(constraint.T_from_to, constraint.information), loss,
                             blocks.at(constraint.from).data(), blocks.at(constraint.to).data());
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = num_threads;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size());
  if (!summary.IsSolutionUsable()) return result;
  for (auto& [id, pose] : poses_) {
    const Eigen::Vector3d& block = blocks.at(id);
    pose = SE2(block.x(), block.y(), block.z());
  }
  return result;
}

}  // namespace arborslam
