#include "backend/graph/map_parts.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

using Kind = Constraint::Kind;

PoseGraph Keyframes(int count) {
  PoseGraph graph;
  for (int i = 0; i < count; ++i) graph.AddNode(KeyframeId{i}, SE2());
  return graph;
}

void Join(int from, int to, Kind kind, PoseGraph* graph) {
  graph->AddConstraint({KeyframeId{from}, KeyframeId{to}, SE2(), Eigen::Matrix3d::Identity(), kind});
}

TEST(MapParts, WithoutGapsAllIsOne) {
  EXPECT_EQ(MapParts(PoseGraph()).num_parts(), 0u);
  PoseGraph graph = Keyframes(4);
  Join(0, 1, Kind::kMotion, &graph);
  const MapParts parts(graph);
  EXPECT_EQ(parts.num_parts(), 1u);
  EXPECT_TRUE(parts.AreJoined(KeyframeId{0}, KeyframeId{3}));
}

TEST(MapParts, AGapSeparatesUntilALoopJoins) {
  PoseGraph graph = Keyframes(5);
  Join(0, 1, Kind::kMotion, &graph);
  Join(1, 2, Kind::kGap, &graph);
  Join(2, 3, Kind::kSubmap, &graph);
  Join(3, 4, Kind::kMotion, &graph);
  const MapParts apart(graph);
  EXPECT_EQ(apart.num_parts(), 2u);
  EXPECT_EQ(apart.main_part(), 1u);
  EXPECT_EQ(apart.Of(KeyframeId{0}), 0u);
  EXPECT_FALSE(apart.AreJoined(KeyframeId{1}, KeyframeId{2}));
  EXPECT_TRUE(apart.AreJoined(KeyframeId{2}, KeyframeId{4}));
  Join(4, 0, Kind::kLoop, &graph);
  const MapParts joined(graph);
  EXPECT_EQ(joined.num_parts(), 1u);
  EXPECT_TRUE(joined.AreJoined(KeyframeId{1}, KeyframeId{2}));
}

}  // namespace
}  // namespace arborslam
