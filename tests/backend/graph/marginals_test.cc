#include "backend/graph/marginals.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <map>

#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

using Kind = Constraint::Kind;

// The error of a constraint when its two poses are perturbed in their own frames.
Eigen::Vector3d Error(const PoseGraph& graph, const Constraint& constraint, const Eigen::Vector3d& d_from,
                      const Eigen::Vector3d& d_to) {
  const SE2 from = graph.Pose(constraint.from) * SE2(d_from.x(), d_from.y(), d_from.z());
  const SE2 to = graph.Pose(constraint.to) * SE2(d_to.x(), d_to.y(), d_to.z());
  return (constraint.T_from_to.Inverse() * from.Inverse() * to).vector();
}

// The inverse of the dense information matrix, with Jacobians by differences in the nodes' own frames.
Eigen::MatrixXd DenseCovariance(const PoseGraph& graph) {
  std::map<NodeId, Eigen::Index> column;
  for (const auto& [id, pose] : graph.poses()) column.emplace(id, 3 * static_cast<Eigen::Index>(column.size()));
  const auto size = 3 * static_cast<Eigen::Index>(column.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (const Constraint& constraint : graph.constraints()) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, size);
    constexpr double kStep = 1e-6;
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
      jacobian.col(column.at(constraint.from) + axis) =
          (Error(graph, constraint, step, none) - Error(graph, constraint, -step, none)) / (2.0 * kStep);
      jacobian.col(column.at(constraint.to) + axis) =
          (Error(graph, constraint, none, step) - Error(graph, constraint, none, -step)) / (2.0 * kStep);
    }
    information += jacobian.transpose() * constraint.information * jacobian;
  }
  return information.bottomRightCorner(size - 3, size - 3).inverse();
}

PoseGraph RandomGraph() {
  Random random(11);
  PoseGraph graph;
  for (int i = 0; i < 30; ++i) graph.AddNode(KeyframeId{i}, RandomPose(&random, 20.0));
  for (int i = 0; i < 3; ++i) graph.AddNode(SubmapId{i}, RandomPose(&random, 20.0));
  const auto add = [&](NodeId from, NodeId to, Kind kind) {
    const Eigen::Matrix3d information = RandomInformation(&random, 0.05, 0.02);
    graph.AddConstraint({from, to, graph.Pose(from).Inverse() * graph.Pose(to), information, kind});
  };
  for (int i = 1; i < 30; ++i) add(KeyframeId{i - 1}, KeyframeId{i}, Kind::kMotion);
  for (int i = 0; i < 30; i += 2) add(SubmapId{i / 10}, KeyframeId{i}, Kind::kSubmap);
  for (int i = 20; i < 30; i += 3) add(SubmapId{0}, KeyframeId{i}, Kind::kLoop);
  return graph;
}

TEST(Marginals, AgreeWithADenseInverse) {
  const PoseGraph graph = RandomGraph();
  const Eigen::MatrixXd dense = DenseCovariance(graph);
  std::vector<NodeId> nodes;
  for (const auto& [id, pose] : graph.poses()) nodes.push_back(id);
  const std::vector<Eigen::Matrix3d> covariances = MarginalCovariances(graph, nodes);
  ASSERT_EQ(covariances.size(), nodes.size());
  EXPECT_EQ(covariances[0], Eigen::Matrix3d::Zero());
  for (size_t i = 1; i < nodes.size(); ++i) {
    const Eigen::Index row = 3 * (static_cast<Eigen::Index>(i) - 1);
    const Eigen::Matrix3d expected = dense.block<3, 3>(row, row);
    EXPECT_LT((covariances[i] - expected).norm(), 1e-5 * expected.norm()) << nodes[i];
  }
}

TEST(Marginals, ASubsetComesInItsOrder) {
  const PoseGraph graph = RandomGraph();
  const std::vector<Eigen::Matrix3d> two = MarginalCovariances(graph, {SubmapId{1}, KeyframeId{7}});
  EXPECT_EQ(two[0], MarginalCovariances(graph, {SubmapId{1}})[0]);
  EXPECT_EQ(two[1], MarginalCovariances(graph, {KeyframeId{7}})[0]);
  EXPECT_TRUE(MarginalCovariances(graph, {}).empty());
}

TEST(Marginals, WhatIsOpenIsInfinite) {
  PoseGraph graph;
  for (int i = 0; i < 4; ++i) graph.AddNode(KeyframeId{i}, SE2(i, 0.5 * i, 0.1 * i));
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  graph.AddConstraint({KeyframeId{0}, KeyframeId{1}, SE2(1.0, 0.0, 0.0), unit, Kind::kMotion});
  graph.AddConstraint({KeyframeId{2}, KeyframeId{3}, SE2(1.0, 0.0, 0.0), unit, Kind::kMotion});
  const std::vector<NodeId> nodes{KeyframeId{0}, KeyframeId{1}, KeyframeId{2}, KeyframeId{3}};
  std::vector<Eigen::Matrix3d> covariances = MarginalCovariances(graph, nodes);
  EXPECT_EQ(covariances[0], Eigen::Matrix3d::Zero());
  EXPECT_LT((covariances[1] - unit).norm(), 2.0);
  EXPECT_EQ(covariances[2](0, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(covariances[3](1, 2), std::numeric_limits<double>::infinity());

  const Eigen::Matrix3d no_y = Eigen::Vector3d(1.0, 0.0, 1.0).asDiagonal();
  graph.AddConstraint({KeyframeId{1}, KeyframeId{2}, SE2(1.0, 0.0, 0.0), no_y, Kind::kSubmap});
  covariances = MarginalCovariances(graph, nodes);
  EXPECT_EQ(covariances[0](0, 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(covariances[3](0, 0), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace arborslam
