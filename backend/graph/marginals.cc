#include "backend/graph/marginals.h"

#include <ceres/cost_function.h>
#include <glog/logging.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>

#include "backend/factors/relative_pose_factor.h"

namespace arborslam {
namespace {

using Jacobian = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
// A pivot this much smaller than the matrix' entry that it was is rounding error.
constexpr double kNullRatio = 1e-12;

// The block column of each node that constraints tie to the graph's first one, which has none itself.
std::map<NodeId, Eigen::Index> TiedColumns(const PoseGraph& graph) {
  std::map<NodeId, std::vector<NodeId>> neighbours;
  for (const Constraint& constraint : graph.constraints()) {
    neighbours[constraint.from].push_back(constraint.to);
    neighbours[constraint.to].push_back(constraint.from);
  }
  const NodeId first = graph.poses().begin()->first;
  std::map<NodeId, Eigen::Index> columns;
  std::vector<NodeId> reached{first};
  while (!reached.empty()) {
    const NodeId node = reached.back();
    reached.pop_back();
    for (const NodeId neighbour : neighbours[node]) {
      if (neighbour == first) continue;
      if (columns.emplace(neighbour, static_cast<Eigen::Index>(columns.size())).second) reached.push_back(neighbour);
    }
  }
  return columns;
}

// The sum of J^T J of all constraints between nodes that have columns; the lower triangle.
Eigen::SparseMatrix<double> Hessian(const PoseGraph& graph, const std::map<NodeId, Eigen::Index>& columns) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Constraint& constraint : graph.constraints()) {
    const std::unique_ptr<ceres::CostFunction> factor(
        CreateRelativePoseFactor(constraint.T_from_to, constraint.information));
    const Eigen::Vector3d poses[] = {graph.Pose(constraint.from).vector(), graph.Pose(constraint.to).vector()};
    const double* const parameters[] = {poses[0].data(), poses[1].data()};
    Eigen::Vector3d residuals;
    Jacobian jacobians[2];
    double* jacobian_data[] = {jacobians[0].data(), jacobians[1].data()};
    CHECK(factor->Evaluate(parameters, residuals.data(), jacobian_data));
    const NodeId nodes[] = {constraint.from, constraint.to};
    for (int i = 0; i < 2; ++i) {
      const auto row = columns.find(nodes[i]);
      if (row == columns.end()) continue;
      for (int j = 0; j < 2; ++j) {
        const auto column = columns.find(nodes[j]);
        if (column == columns.end() || column->second > row->second) continue;
        const Eigen::Matrix3d block = jacobians[i].transpose() * jacobians[j];
        for (Eigen::Index r = 0; r < 3; ++r) {
          for (Eigen::Index c = 0; c < 3; ++c) {
            entries.emplace_back(3 * row->second + r, 3 * column->second + c, block(r, c));
          }
        }
      }
    }
  }
  const auto size = 3 * static_cast<Eigen::Index>(columns.size());
  Eigen::SparseMatrix<double> hessian(size, size);
  hessian.setFromTriplets(entries.begin(), entries.end());
  return hessian;
}

}  // namespace

std::vector<Eigen::Matrix3d> MarginalCovariances(const PoseGraph& graph, const std::vector<NodeId>& nodes) {
  if (nodes.empty()) return {};
  std::vector<Eigen::Matrix3d> covariances(nodes.size(),
                                           Eigen::Matrix3d::Constant(std::numeric_limits<double>::infinity()));
  const std::map<NodeId, Eigen::Index> columns = TiedColumns(graph);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> cholesky;
  if (!columns.empty()) {
    const Eigen::SparseMatrix<double> hessian = Hessian(graph, columns);
    cholesky.compute(hessian);
    const Eigen::VectorXd pivots = cholesky.vectorD();
    const Eigen::VectorXd limits = kNullRatio * (cholesky.permutationP() * hessian.diagonal().eval());
    if (cholesky.info() != Eigen::Success || !(pivots.array() > limits.array()).all()) return covariances;
  }
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] == graph.poses().begin()->first) {
      covariances[i].setZero();
      continue;
    }
    const auto column = columns.find(nodes[i]);
    if (column == columns.end()) continue;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(columns.size()), 3);
    unit.middleRows<3>(3 * column->second).setIdentity();
    const Eigen::Matrix3d in_map = Eigen::MatrixXd(cholesky.solve(unit)).middleRows<3>(3 * column->second);
    // From the block of x, y, theta to the node's own frame.
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    rotation.topLeftCorner<2, 2>() = graph.Pose(nodes[i]).rotation().transpose();
    covariances[i] = rotation * in_map * rotation.transpose();
  }
  return covariances;
}

}  // namespace arborslam
