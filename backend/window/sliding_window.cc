#include "backend/window/sliding_window.h"

#include <ceres/cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "backend/factors/relative_pose_factor.h"

namespace arborslam {
namespace {

// Directions whose information is this much less than the greatest are taken to be unknown.
constexpr double kNullRatio = 1e-13;

using RowMajorJacobian = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

ceres::Problem::Options OwnNothing() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

// The prior whose cost is half of d^T hessian d, plus gradient^T d and a constant, where d is the difference from
// `linearisation_point`: hessian = J^T J and gradient = J^T offset, by Cholesky with full diagonal pivoting up to the
// rank of the hessian. (Eigen's LDLT takes pivots by the diagonal as it was, which does not reveal the rank.)
MarginalPrior PriorOf(Eigen::MatrixXd hessian, Eigen::VectorXd gradient, std::vector<SE2> linearisation_point) {
  MarginalPrior prior;
  prior.linearisation_point = std::move(linearisation_point);
  prior.jacobian.resize(hessian.rows(), hessian.cols());
  prior.offset.resize(hessian.rows());
  const double limit = kNullRatio * hessian.diagonal().maxCoeff();
  Eigen::Index rank = 0;
  for (; rank < hessian.rows(); ++rank) {
    Eigen::Index pivot = 0;
    const double value = hessian.diagonal().maxCoeff(&pivot);
    if (!(value > limit)) break;
    const Eigen::VectorXd row = hessian.col(pivot) / std::sqrt(value);
    const double offset = gradient(pivot) / std::sqrt(value);
    prior.jacobian.row(rank) = row.transpose();
    prior.offset(rank) = offset;
    hessian.noalias() -= row * row.transpose();
    hessian(pivot, pivot) = 0.0;
    gradient -= offset * row;
  }
  prior.jacobian.conservativeResize(rank, Eigen::NoChange);
  prior.offset.conservativeResize(rank);
  return prior;
}

// The inverse of a positive semi-definite matrix, 0 in its null directions.
Eigen::MatrixXd PseudoInverse(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  const double limit = kNullRatio * eigen.eigenvalues().maxCoeff();
  const Eigen::VectorXd inverse_values =
      eigen.eigenvalues().unaryExpr([limit](double value) { return value > limit ? 1.0 / value : 0.0; });
  return eigen.eigenvectors() * inverse_values.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

void SlidingWindow::AddNode(NodeId id, const SE2& initial) {
  CHECK(poses_.emplace(id, initial).second) << id << " is in the window already";
}

void SlidingWindow::AddPrior(NodeId id, const Eigen::Matrix3d& information) {
  CHECK(Has(id)) << id;
  const MarginalPrior prior{{Pose(id)}, SquareRoot(information), Eigen::Vector3d::Zero()};
  AddFactor({id}, Source(prior));
}

void SlidingWindow::AddConstraint(const Constraint& constraint) {
  CHECK(Has(constraint.from) && Has(constraint.to)) << constraint.from << " to " << constraint.to;
  CHECK(constraint.information.allFinite() && constraint.T_from_to.vector().allFinite())
      << constraint.from << " to " << constraint.to << " is not finite";
  AddFactor({constraint.from, constraint.to}, Source(constraint));
}

std::shared_ptr<ceres::CostFunction> SlidingWindow::CostOf(const Source& source) {
  return std::shared_ptr<ceres::CostFunction>(
      source.is_prior ? CreateMarginalPriorFactor(source.prior)
                      : CreateRelativePoseFactor(source.measurement.T_from_to, source.measurement.information));
}

bool SlidingWindow::IsWhole(const Factor& factor) const {
  for (const NodeId node : factor.nodes) {
    if (!Has(node)) return false;
  }
  if (!factor.source.is_prior) return factor.nodes.size() == 2;
  const MarginalPrior& prior = factor.source.prior;
  return !factor.nodes.empty() && prior.linearisation_point.size() == factor.nodes.size() &&
         prior.jacobian.cols() == 3 * static_cast<Eigen::Index>(factor.nodes.size()) && prior.jacobian.rows() > 0 &&
         prior.offset.size() == prior.jacobian.rows();
}

void SlidingWindow::AddFactor(std::vector<NodeId> nodes, Source source) {
  std::shared_ptr<ceres::CostFunction> cost = CostOf(source);
  factors_.push_back({std::move(nodes), std::move(source), std::move(cost)});
}

void SlidingWindow::Solve() {
  std::map<NodeId, Eigen::Vector3d> blocks;
  for (const auto& [id, pose] : poses_) blocks.emplace(id, pose.vector());
  ceres::Problem problem(OwnNothing());
  std::vector<double*> parameters;
  for (const Factor& factor : factors_) {
    parameters.clear();
    for (const NodeId node : factor.nodes) parameters.push_back(blocks.at(node).data());
    problem.AddResidualBlock(factor.cost.get(), nullptr, parameters);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 10;
  // The poses are then within about a thousandth of a standard deviation of the minimum. Less is rounding error after
  // tens of thousands of keyframes, and steps that chase it would make late keyframes dearer than early ones.
  options.function_tolerance = 1e-8;
  // Nearly undamped from the start: the poses are near their optimum, and so two or three steps do.
  options.initial_trust_region_radius = 1e10;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  LOG_IF(WARNING, !summary.IsSolutionUsable()) << summary.message;
  if (!summary.IsSolutionUsable()) return;
  for (auto& [id, pose] : poses_) {
    const Eigen::Vector3d& block = blocks.at(id);
    pose = SE2(block.x(), block.y(), block.z());
  }
}

SlidingWindow::Quadratic SlidingWindow::Linearize(const std::vector<NodeId>& nodes,
                                                  const std::vector<Factor>& factors) const {
  std::map<NodeId, Eigen::Index> column;
  for (const NodeId node : nodes) column.emplace(node, 3 * static_cast<Eigen::Index>(column.size()));
  const auto size = 3 * static_cast<Eigen::Index>(nodes.size());
  Quadratic quadratic{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size)};
  for (const Factor& factor : factors) {
    std::vector<Eigen::Vector3d> poses;
    std::vector<RowMajorJacobian> jacobians;
    for (const NodeId node : factor.nodes) {
      poses.push_back(Pose(node).vector());
      jacobians.emplace_back(factor.cost->num_residuals(), 3);
    }
    std::vector<double*> parameters;
    std::vector<double*> jacobian_data;
    for (size_t i = 0; i < factor.nodes.size(); ++i) {
      parameters.push_back(poses[i].data());
      jacobian_data.push_back(jacobians[i].data());
    }
    Eigen::VectorXd residuals(factor.cost->num_residuals());
    CHECK(factor.cost->Evaluate(parameters.data(), residuals.data(), jacobian_data.data()));
    for (size_t i = 0; i < factor.nodes.size(); ++i) {
      const Eigen::Index row = column.at(factor.nodes[i]);
      quadratic.gradient.segment<3>(row) += jacobians[i].transpose() * residuals;
      for (size_t j = 0; j < factor.nodes.size(); ++j) {
        quadratic.hessian.block<3, 3>(row, column.at(factor.nodes[j])) += jacobians[i].transpose() * jacobians[j];
      }
    }
  }
  return quadratic;
}

void SlidingWindow::Marginalize(NodeId id) {
  CHECK(Has(id)) << id;
  // The factors that know the pose leave the window with it.
  const auto leaving = std::stable_partition(factors_.begin(), factors_.end(), [id](const Factor& factor) {
    return std::find(factor.nodes.begin(), factor.nodes.end(), id) == factor.nodes.end();
  });
  const std::vector<Factor> factors(leaving, factors_.end());
  factors_.erase(leaving, factors_.end());

  std::vector<NodeId> nodes{id};
  for (const Factor& factor : factors) {
    for (const NodeId node : factor.nodes) {
      if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
    }
  }
  const Quadratic quadratic = Linearize(nodes, factors);
  poses_.erase(id);
  const Eigen::Index kept = quadratic.gradient.size() - 3;
  if (kept == 0) return;

  // Schur complement on the first block.
  const Eigen::Matrix3d inverse = PseudoInverse(quadratic.hessian.topLeftCorner<3, 3>());
  const Eigen::MatrixXd cross = quadratic.hessian.bottomLeftCorner(kept, 3);
  const Eigen::MatrixXd hessian = quadratic.hessian.bottomRightCorner(kept, kept) - cross * inverse * cross.transpose();
  const Eigen::VectorXd gradient = quadratic.gradient.tail(kept) - cross * inverse * quadratic.gradient.head<3>();
  nodes.erase(nodes.begin());
  std::vector<SE2> linearisation_point;
  for (const NodeId node : nodes) linearisation_point.push_back(poses_.at(node));
  const MarginalPrior prior = PriorOf(hessian, gradient, std::move(linearisation_point));
  if (prior.offset.size() == 0) return;
  AddFactor(std::move(nodes), Source(prior));
}

Eigen::Matrix3d SlidingWindow::Covariance(NodeId id) const {
  CHECK(Has(id)) << id;
  std::vector<NodeId> nodes{id};
  for (const auto& [node, pose] : poses_) {
    if (!(node == id)) nodes.push_back(node);
  }
  const Quadratic quadratic = Linearize(nodes, factors_);
  const Eigen::MatrixXd columns = PseudoInverse(quadratic.hessian).leftCols<3>();
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(columns.rows(), 3);
  unit.topRows<3>().setIdentity();
  const bool is_determined = (quadratic.hessian * columns - unit).cwiseAbs().maxCoeff() < 1e-3;
  if (!is_determined) return Eigen::Matrix3d::Constant(std::numeric_limits<double>::infinity());
  return columns.topRows<3>();
}

}  // namespace arborslam
