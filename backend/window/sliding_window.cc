#include "backend/window/sliding_window.h"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>

#include "backend/factors/relative_pose_factor.h"

namespace arborslam {
namespace {

// Directions whose information is this much less than the greatest are taken to be unknown.
constexpr double kNullRatio = 1e-12;

using Blocks = std::map<NodeId, Eigen::Vector3d>;

Blocks ToBlocks(const std::map<NodeId, SE2>& poses) {
  Blocks blocks;
  for (const auto& [id, pose] : poses) blocks[id] = pose.vector();
  return blocks;
}

}  // namespace

void SlidingWindow::AddNode(NodeId id, const SE2& initial) {
  CHECK(poses_.emplace(id, initial).second) << id << " is in the window already";
}

void SlidingWindow::AddPrior(NodeId id, const Eigen::Matrix3d& information) {
  priors_.push_back({{id}, {{poses_.at(id)}, SquareRoot(information), Eigen::Vector3d::Zero()}});
}

void SlidingWindow::AddConstraint(const Constraint& constraint) {
  CHECK(Has(constraint.from) && Has(constraint.to)) << constraint.from << " to " << constraint.to;
  constraints_.push_back(constraint);
}

void SlidingWindow::Solve() {
  Blocks blocks = ToBlocks(poses_);
  ceres::Problem problem;
  for (const Constraint& constraint : constraints_) {
    problem.AddResidualBlock(CreateRelativePoseFactor(constraint.T_from_to, constraint.information), nullptr,
                             blocks.at(constraint.from).data(), blocks.at(constraint.to).data());
  }
  for (const Prior& prior : priors_) {
    std::vector<double*> parameters;
    for (const NodeId node : prior.nodes) parameters.push_back(blocks.at(node).data());
    problem.AddResidualBlock(CreateMarginalPriorFactor(prior.prior), nullptr, parameters);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 10;
  options.function_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return;
  for (auto& [id, pose] : poses_) {
    const Eigen::Vector3d& block = blocks.at(id);
    pose = SE2(block.x(), block.y(), block.z());
  }
}

SlidingWindow::Quadratic SlidingWindow::Linearize(const std::vector<NodeId>& nodes,
                                                  const std::vector<Constraint>& constraints,
                                                  const std::vector<Prior>& priors) const {
  Blocks blocks = ToBlocks(poses_);
  std::map<NodeId, Eigen::Index> column;
  for (const NodeId node : nodes) column.emplace(node, 3 * static_cast<Eigen::Index>(column.size()));
  const auto size = 3 * static_cast<Eigen::Index>(nodes.size());
  Quadratic quadratic{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const auto add = [&](const ceres::CostFunction& factor, const std::vector<NodeId>& of) {
    std::vector<double*> parameters;
    std::vector<RowMajor> jacobians;
    std::vector<double*> jacobian_data;
    for (const NodeId node : of) {
      parameters.push_back(blocks.at(node).data());
      jacobians.emplace_back(factor.num_residuals(), 3);
    }
    for (RowMajor& jacobian : jacobians) jacobian_data.push_back(jacobian.data());
    Eigen::VectorXd residuals(factor.num_residuals());
    CHECK(factor.Evaluate(parameters.data(), residuals.data(), jacobian_data.data()));
    for (size_t i = 0; i < of.size(); ++i) {
      quadratic.gradient.segment<3>(column.at(of[i])) += jacobians[i].transpose() * residuals;
      for (size_t j = 0; j < of.size(); ++j) {
        quadratic.hessian.block<3, 3>(column.at(of[i]), column.at(of[j])) += jacobians[i].transpose() * jacobians[j];
      }
    }
  };
  for (const Constraint& constraint : constraints) {
    const std::unique_ptr<ceres::CostFunction> factor(
        CreateRelativePoseFactor(constraint.T_from_to, constraint.information));
    add(*factor, {constraint.from, constraint.to});
  }
  for (const Prior& prior : priors) {
    const std::unique_ptr<ceres::CostFunction> factor(CreateMarginalPriorFactor(prior.prior));
    add(*factor, prior.nodes);
  }
  return quadratic;
}

void SlidingWindow::Marginalize(NodeId id) {
  // The factors that know the pose leave the window with it.
  const auto left_constraints = std::stable_partition(
      constraints_.begin(), constraints_.end(), [id](const Constraint& c) { return !(c.from == id) && !(c.to == id); });
  const std::vector<Constraint> constraints(left_constraints, constraints_.end());
  constraints_.erase(left_constraints, constraints_.end());
  const auto left_priors = std::stable_partition(priors_.begin(), priors_.end(), [id](const Prior& prior) {
    return std::find(prior.nodes.begin(), prior.nodes.end(), id) == prior.nodes.end();
  });
  const std::vector<Prior> priors(left_priors, priors_.end());
  priors_.erase(left_priors, priors_.end());

  std::vector<NodeId> nodes{id};
  const auto meet = [&nodes](NodeId node) {
    if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
  };
  for (const Constraint& constraint : constraints) {
    meet(constraint.from);
    meet(constraint.to);
  }
  for (const Prior& prior : priors) std::for_each(prior.nodes.begin(), prior.nodes.end(), meet);

  const Quadratic quadratic = Linearize(nodes, constraints, priors);
  poses_.erase(id);
  const Eigen::Index kept = quadratic.gradient.size() - 3;
  if (kept == 0) return;

  // Schur complement on the first block; an unknown direction of the leaving pose has nothing to pass on.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> leaving(quadratic.hessian.topLeftCorner<3, 3>());
  const double limit = kNullRatio * std::max(leaving.eigenvalues()(2), 1e-300);
  const Eigen::Vector3d inverse_values =
      leaving.eigenvalues().unaryExpr([limit](double value) { return value > limit ? 1.0 / value : 0.0; });
  const Eigen::Matrix3d inverse =
      leaving.eigenvectors() * inverse_values.asDiagonal() * leaving.eigenvectors().transpose();
  const Eigen::MatrixXd cross = quadratic.hessian.bottomLeftCorner(kept, 3);
  const Eigen::MatrixXd hessian = quadratic.hessian.bottomRightCorner(kept, kept) - cross * inverse * cross.transpose();
  const Eigen::VectorXd gradient = quadratic.gradient.tail(kept) - cross * inverse * quadratic.gradient.head<3>();

  // hessian = J^T J and gradient = J^T offset.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(hessian);
  const double null_limit = kNullRatio * std::max(eigen.eigenvalues()(kept - 1), 1e-300);
  Eigen::Index first = 0;
  while (first < kept && eigen.eigenvalues()(first) <= null_limit) ++first;
  const Eigen::Index rank = kept - first;
  if (rank == 0) return;
  const Eigen::VectorXd roots = eigen.eigenvalues().tail(rank).cwiseSqrt();
  const Eigen::MatrixXd vectors = eigen.eigenvectors().rightCols(rank);
  Prior prior;
  prior.prior.jacobian = roots.asDiagonal() * vectors.transpose();
  prior.prior.offset = roots.cwiseInverse().asDiagonal() * (vectors.transpose() * gradient);
  prior.nodes.assign(nodes.begin() + 1, nodes.end());
  for (const NodeId node : prior.nodes) prior.prior.linearisation_point.push_back(poses_.at(node));
  priors_.push_back(std::move(prior));
}

Eigen::Matrix3d SlidingWindow::Covariance(NodeId id) const {
  std::vector<NodeId> nodes{id};
  for (const auto& [node, pose] : poses_) {
    if (!(node == id)) nodes.push_back(node);
  }
  const Quadratic quadratic = Linearize(nodes, constraints_, priors_);
  const Eigen::LDLT<Eigen::MatrixXd> factored(quadratic.hessian);
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(quadratic.gradient.size(), 3);
  unit.topRows<3>().setIdentity();
  return factored.solve(unit).topRows<3>();
}

}  // namespace arborslam
