#include "backend/graph/overlap_discount.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

using Kind = Constraint::Kind;

TEST(OverlapDiscount, MatchesShareOneBetweenThemAndTheirNeighbours) {
  // A keyframe every half metre; the first has two matches, the others one.
  PoseGraph graph;
  for (int s = 0; s < 2; ++s) graph.AddNode(SubmapId{s}, SE2());
  for (int i = 0; i < 9; ++i) graph.AddNode(KeyframeId{i}, SE2(0.5 * i, 0.0, 0.1 * i));
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  graph.AddConstraint({SubmapId{1}, KeyframeId{0}, SE2(), unit, Kind::kLoop});
  for (int i = 0; i < 9; ++i)
    graph.AddConstraint({SubmapId{0}, KeyframeId{i}, SE2(0.5 * i, 0.0, 0.0), unit, Kind::kSubmap});
  graph.AddConstraint({KeyframeId{0}, KeyframeId{1}, SE2(), unit, Kind::kMotion});

  const PoseGraph discounted = DiscountOverlap(graph, 2.0);
  ASSERT_EQ(discounted.constraints().size(), graph.constraints().size());
  const auto share = [&discounted](size_t i) { return discounted.constraints()[i].information(0, 0); };
  EXPECT_DOUBLE_EQ(share(0), 1.0 / (2.0 * 3.0));  // Two more keyframes within 1 m.
  EXPECT_DOUBLE_EQ(share(1), 1.0 / (2.0 * 3.0));
  EXPECT_DOUBLE_EQ(share(2), 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(share(5), 1.0 / 5.0);  // Amid the others.
  EXPECT_DOUBLE_EQ(share(9), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(share(10), 1.0);  // Motion.
  for (const auto& [id, pose] : graph.poses()) EXPECT_EQ(discounted.Pose(id).vector(), pose.vector());
}

TEST(OverlapDiscount, FarKeyframesKeepAllOfASingleMatch) {
  PoseGraph graph;
  graph.AddNode(SubmapId{0}, SE2());
  for (int i = 0; i < 3; ++i) graph.AddNode(KeyframeId{i}, SE2(5.0 * i, 0.0, 0.0));
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) graph.AddConstraint({SubmapId{0}, KeyframeId{i}, SE2(), unit, Kind::kSubmap});
  const PoseGraph discounted = DiscountOverlap(graph);
  ASSERT_FALSE(discounted.constraints().empty());
  for (const Constraint& constraint : discounted.constraints()) EXPECT_EQ(constraint.information, unit);
  EXPECT_TRUE(DiscountOverlap(PoseGraph()).poses().empty());
}

}  // namespace
}  // namespace arborslam
