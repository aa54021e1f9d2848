#include "backend/refine/map_refiner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/backend/planar_posts.h"
#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

TEST(MapRefinementOptions, ValuesOutOfRangeAreNamed) {
  EXPECT_EQ(MapRefinementOptions().Validate(), "");
  MapRefinementOptions options;
  options.num_passes = -1;
  EXPECT_EQ(options.Validate().substr(0, 10), "num_passes");
  options = {};
  options.radius = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(options.Validate().substr(0, 6), "radius");
}

class MapRefinerTest : public testing::Test {
 protected:
  MapRefinerTest()
      : run_(StrewnPosts(60, 40.0, 3), Path()), refiner_({}, OccupancyGridOptions(), 0.55, 0.2, Matcher({}, {}, {})) {
    run_.AddSubmap(0, 19, OccupancyGridOptions());
    run_.AddSubmap(20, 39, OccupancyGridOptions());
  }

  static std::vector<SE2> Path() {
    std::vector<SE2> path;
    for (int i = 0; i < 20; ++i) path.emplace_back(0.5 * i - 5.0, 0.0, 0.0);
    for (int i = 0; i < 20; ++i) path.emplace_back(4.5 - 0.5 * i, 0.4, 3.0);
    return path;
  }

  // All poses but the first off by about `sigma` [m, and a tenth of it in rad].
  PoseGraph Graph(double sigma) const {
    Random random(8);
    const Eigen::Matrix3d information =
        Eigen::Vector3d(1.0, 1.0, 100.0).asDiagonal() * Eigen::Matrix3d::Identity() / (sigma * sigma);
    PoseGraph graph;
    for (size_t i = 0; i < run_.truth.size(); ++i) {
      const SE2 pose = i == 0 ? run_.truth[i] : Disturbed(run_.truth[i], information, 1.0, &random);
      graph.AddNode(KeyframeId{static_cast<int>(i)}, pose);
    }
    for (const Submap& submap : run_.submaps) graph.AddNode(submap.id, graph.Pose(submap.keyframes.front()));
    return graph;
  }

  double ErrorOf(const PoseGraph& graph) const {
    double sum = 0.0;
    for (size_t i = 0; i < run_.truth.size(); ++i) {
      const SE2& pose = graph.Pose(KeyframeId{static_cast<int>(i)});
      sum += (pose.translation() - run_.truth[i].translation()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(run_.truth.size()));
  }

  PostsRun run_;
  MapRefiner refiner_;
};

TEST_F(MapRefinerTest, PassesBringThePosesToTheTruth) {
  PoseGraph graph = Graph(0.03);
  const double before = ErrorOf(graph);
  for (int pass = 0; pass < 3; ++pass) {
    graph = refiner_.Remeasure(graph, run_.keyframes, &run_.submaps, 1);
    graph.Optimize({}, 1);
  }
  EXPECT_GT(before, 0.03);
  EXPECT_LT(ErrorOf(graph), 0.5 * before);
}

// From half a metre off nothing can be refined: the posts are thinner.
TEST_F(MapRefinerTest, AScanThatNoMapHoldsIsSearchedFor) {
  // Cells count from two hits on, so that the scan's own submap does not hold it where it wrongly lies.
  const MapRefiner refiner({}, OccupancyGridOptions(), 0.75, 0.2, Matcher({}, {}, {}));
  const KeyframeId lost{10};
  const SE2& truth = run_.truth[static_cast<size_t>(lost.value)];
  PoseGraph graph;
  for (size_t i = 0; i < run_.truth.size(); ++i) {
    const KeyframeId id{static_cast<int>(i)};
    graph.AddNode(id, id == lost ? truth * SE2(0.5, -0.4, 0.1) : run_.truth[i]);
  }
  for (const Submap& submap : run_.submaps) graph.AddNode(submap.id, run_.TruthOf(submap));
  graph = refiner.Remeasure(graph, run_.keyframes, &run_.submaps, 1);
  graph.Optimize({}, 1);
  EXPECT_TRUE(graph.Pose(lost).IsApprox(truth, 0.03)) << graph.Pose(lost) << truth;
}

TEST_F(MapRefinerTest, KeepsNodesAndMotionAndMeasuresAnew) {
  PoseGraph graph = Graph(0.01);
  const Constraint motion{KeyframeId{3}, KeyframeId{4}, SE2(0.5, 0.0, 0.0), Eigen::Matrix3d::Identity(),
                          Constraint::Kind::kMotion};
  graph.AddConstraint(motion);
  graph.AddConstraint(
      {SubmapId{0}, KeyframeId{4}, SE2(9.0, 9.0, 2.0), Eigen::Matrix3d::Identity(), Constraint::Kind::kLoop});
  const PoseGraph refined = refiner_.Remeasure(graph, run_.keyframes, &run_.submaps, 1);
  ASSERT_EQ(refined.poses().size(), graph.poses().size());
  for (const auto& [id, pose] : graph.poses()) EXPECT_EQ(refined.Pose(id).vector(), pose.vector());
  int num_motion = 0;
  int num_measured = 0;
  for (const Constraint& constraint : refined.constraints()) {
    if (constraint.kind == Constraint::Kind::kMotion) {
      ++num_motion;
      continue;
    }
    ++num_measured;
    const SE2 truth = run_.TruthOf(run_.submaps[static_cast<size_t>(constraint.from.value)]).Inverse() *
                      run_.truth[static_cast<size_t>(constraint.to.value)];
    EXPECT_TRUE(constraint.T_from_to.IsApprox(truth, 0.15)) << constraint.from << constraint.to;
    // Where another submap sees a keyframe, its own says nothing that it does not already know.
    const bool is_own = (constraint.from.value == 0) == (constraint.to.value < 20);
    EXPECT_EQ(constraint.kind, is_own ? Constraint::Kind::kSubmap : Constraint::Kind::kLoop);
  }
  EXPECT_EQ(num_motion, 1);
  EXPECT_GE(num_measured, 35);
}

TEST_F(MapRefinerTest, AnyNumberOfThreadsMeasuresTheSame) {
  const PoseGraph graph = Graph(0.02);
  std::vector<Submap> submaps = run_.submaps;
  const PoseGraph one = refiner_.Remeasure(graph, run_.keyframes, &run_.submaps, 1);
  const PoseGraph three = refiner_.Remeasure(graph, run_.keyframes, &submaps, 3);
  ASSERT_EQ(one.constraints().size(), three.constraints().size());
  for (size_t i = 0; i < one.constraints().size(); ++i) {
    EXPECT_EQ(one.constraints()[i].T_from_to.vector(), three.constraints()[i].T_from_to.vector());
    EXPECT_EQ(one.constraints()[i].information, three.constraints()[i].information);
  }
  for (size_t i = 0; i < submaps.size(); ++i) {
    ASSERT_EQ(submaps[i].cells.Get()->size(), run_.submaps[i].cells.Get()->size());
    EXPECT_FALSE(submaps[i].cells.Get()->empty());
  }
}

}  // namespace
}  // namespace arborslam
