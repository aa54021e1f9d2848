#include "backend/loop/loop_closer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"
#include "frontend/projection/laser_projection.h"
#include "tests/backend/grid_orchard.h"
#include "tests/backend/planar_posts.h"

namespace arborslam {
namespace {

TEST(LoopOptions, ValuesOutOfRangeAreNamed) {
  EXPECT_EQ(LoopOptions().Validate(), "");
  LoopOptions options;
  options.keyframe_stride = 0;
  EXPECT_EQ(options.Validate().substr(0, 15), "keyframe_stride");
  options = {};
  options.candidate_radius = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(options.Validate().substr(0, 16), "candidate_radius");
  options = {};
  options.search_rotation = 4.0;
  EXPECT_EQ(options.Validate().substr(0, 15), "search_rotation");
  options = {};
  options.rival_share = 0.0;
  EXPECT_EQ(options.Validate().substr(0, 11), "rival_share");
}

// There along a line and back along the same line, 1 m a keyframe; the submap is made of the first ten.
class LoopCloserTest : public testing::Test {
 protected:
  LoopCloserTest()
      : run_(StrewnPosts(60, 40.0, 3), Path()), closer_(options_, {}, Matcher({}, {}, {}), OccupancyGridOptions()) {
    run_.AddSubmap(0, 9, OccupancyGridOptions());
  }

  static std::vector<SE2> Path() {
    std::vector<SE2> path;
    for (int i = 0; i < 20; ++i) path.emplace_back(i - 10.0, 0.0, 0.0);
    for (int i = 0; i < 20; ++i) path.emplace_back(9.0 - i, 0.4, 3.0);
    return path;
  }

  // The true graph, but for the way back, which has drifted by `drift`.
  PoseGraph Graph(const SE2& drift) const {
    PoseGraph graph;
    for (size_t i = 0; i < run_.truth.size(); ++i) {
      graph.AddNode(KeyframeId{static_cast<int>(i)}, i < 20 ? run_.truth[i] : run_.truth[i] * drift);
    }
    graph.AddNode(SubmapId{0}, run_.TruthOf(run_.submaps[0]));
    return graph;
  }

  static LoopOptions EveryFourth() {
    LoopOptions options;
    options.keyframe_stride = 4;
    return options;
  }

  const LoopOptions options_ = EveryFourth();
  PostsRun run_;
  LoopCloser closer_;
};

TEST_F(LoopCloserTest, FindsTheTruthInSpiteOfDrift) {
  const PoseGraph graph = Graph(SE2(0.5, -0.6, 0.05));
  const std::vector<LoopCandidate> candidates = closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1);
  int num_accepted = 0;
  for (const LoopCandidate& candidate : candidates) {
    EXPECT_EQ(candidate.accepted, candidate.reason.empty());
    EXPECT_GE(candidate.keyframe.value, 10) << "a member of the submap";
    EXPECT_EQ(candidate.keyframe.value % options_.keyframe_stride, 0);
    if (!candidate.accepted) continue;
    ++num_accepted;
    const SE2 truth = run_.truth[0].Inverse() * run_.truth[static_cast<size_t>(candidate.keyframe.value)];
    EXPECT_TRUE(candidate.match.pose.IsApprox(truth, 0.03)) << candidate.match.pose << truth;
  }
  EXPECT_GE(num_accepted, 4);
}

TEST_F(LoopCloserTest, WhatIsFarOrKnownOrSpoiltIsNotTried) {
  PoseGraph graph = Graph(SE2());
  const std::vector<LoopCandidate> all = closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1);
  ASSERT_GE(all.size(), 2u);
  // Nothing tells how well the poses are known: they may be as far off as is searched.
  const double reach = options_.candidate_radius + options_.max_search_translation - options_.search_translation;
  for (const LoopCandidate& candidate : all) {
    const SE2& pose = graph.Pose(candidate.keyframe);
    EXPECT_LE(pose.x(), -1.0 + reach) << "the submap ends at -1 m";
  }
  graph.AddConstraint({SubmapId{0}, all[0].keyframe, SE2(), Eigen::Matrix3d::Identity(), Constraint::Kind::kSubmap});
  const std::vector<LoopCandidate> fewer = closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1);
  ASSERT_EQ(fewer.size(), all.size() - 1);
  EXPECT_TRUE(fewer[0].keyframe == all[1].keyframe);
  std::vector<Keyframe> spoilt = run_.keyframes;
  for (Keyframe& keyframe : spoilt) keyframe = {keyframe.id, keyframe.scan, false};
  EXPECT_TRUE(closer_.FindAll(graph, graph, spoilt, run_.submaps, {}, 1).empty());
}

// Where most scans were of no use, neither the few others nor the submap of them are believed.
TEST_F(LoopCloserTest, StretchesInWhichTheRunWasLostAreNotTried) {
  const PoseGraph graph = Graph(SE2());
  const auto tried_with = [&](size_t first, size_t end, size_t stride) {
    std::vector<Keyframe> keyframes = run_.keyframes;
    for (size_t i = first; i < end; ++i) keyframes[i].is_inserted = i % stride == 0;
    return closer_.FindAll(graph, graph, keyframes, run_.submaps, {}, 1);
  };
  const std::vector<LoopCandidate> all = tried_with(0, 0, 1);
  ASSERT_GE(all.back().keyframe.value, 28) << "the way back";
  const std::vector<LoopCandidate> with_a_lost_end = tried_with(20, 40, 4);
  for (const LoopCandidate& candidate : with_a_lost_end) EXPECT_LE(candidate.keyframe.value, 20);
  EXPECT_LT(with_a_lost_end.size(), all.size());
  EXPECT_TRUE(tried_with(0, 10, 4).empty()) << "the submap's";
  EXPECT_EQ(tried_with(0, 40, 2).size(), all.size()) << "every other is enough";
}

TEST_F(LoopCloserTest, AnotherPlaceIsRefused) {
  // The submap of another world: nothing of it is where the keyframes are.
  PostsRun other(StrewnPosts(60, 40.0, 99), Path());
  other.AddSubmap(0, 9, OccupancyGridOptions());
  for (const LoopCandidate& candidate :
       closer_.FindAll(Graph(SE2()), Graph(SE2()), run_.keyframes, other.submaps, {}, 1)) {
    EXPECT_FALSE(candidate.accepted) << candidate.keyframe.value << " at " << candidate.match.score;
    EXPECT_FALSE(candidate.reason.empty());
  }
}

TEST_F(LoopCloserTest, AnyNumberOfThreadsFindsTheSame) {
  run_.AddSubmap(5, 14, OccupancyGridOptions());
  PoseGraph graph = Graph(SE2(0.2, 0.1, 0.02));
  graph.AddNode(SubmapId{1}, run_.TruthOf(run_.submaps[1]));
  const std::vector<LoopCandidate> one = closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1);
  const std::vector<LoopCandidate> three = closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 3);
  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_TRUE(one[i].keyframe == three[i].keyframe && one[i].submap == three[i].submap);
    EXPECT_EQ(one[i].match.pose.vector(), three[i].match.pose.vector());
    EXPECT_EQ(one[i].reason, three[i].reason);
  }
}

TEST_F(LoopCloserTest, OnlySoManySubmapsAreTriedForAKeyframe) {
  for (int i = 1; i < 6; ++i) run_.AddSubmap(0, 9, OccupancyGridOptions());
  PoseGraph graph = Graph(SE2());
  for (int i = 1; i < 6; ++i) graph.AddNode(SubmapId{i}, run_.truth[0]);
  std::map<int, int> tried;
  for (const LoopCandidate& candidate : closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1)) {
    ++tried[candidate.keyframe.value];
  }
  ASSERT_FALSE(tried.empty());
  for (const auto& [keyframe, count] : tried) EXPECT_EQ(count, options_.max_submaps) << keyframe;
}

TEST_F(LoopCloserTest, TheWindowFollowsWhatIsKnown) {
  PoseGraph graph = Graph(SE2());
  for (const LoopCandidate& candidate : closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1)) {
    EXPECT_EQ(candidate.search_translation, options_.max_search_translation) << "nothing leads there";
  }
  // Another submap that keyframe 5 ties to the first one, well, and that the way back is tied to by 0.5 m.
  graph.AddNode(SubmapId{7}, run_.truth[5]);
  const Eigen::Matrix3d good = 1e6 * Eigen::Matrix3d::Identity();
  graph.AddConstraint({SubmapId{0}, KeyframeId{5}, SE2(), good, Constraint::Kind::kSubmap});
  graph.AddConstraint({SubmapId{7}, KeyframeId{5}, SE2(), good, Constraint::Kind::kSubmap});
  const Eigen::Matrix3d poor = Eigen::Vector3d(3.0, 3.0, 1e6).asDiagonal();
  for (int i = 20; i < 40; ++i) {
    graph.AddConstraint({SubmapId{7}, KeyframeId{i}, SE2(), poor, Constraint::Kind::kSubmap});
  }
  int num_tied = 0;
  for (const LoopCandidate& candidate : closer_.FindAll(graph, graph, run_.keyframes, run_.submaps, {}, 1)) {
    if (candidate.keyframe.value < 20) continue;
    ++num_tied;
    EXPECT_NEAR(candidate.search_translation, 1.5, 0.1) << "three times 0.5 m";
    EXPECT_EQ(candidate.search_rotation, options_.search_rotation);
  }
  EXPECT_GE(num_tied, 1);
}

// Equal trees on an exact grid, walked through twice; the second time the graph has drifted by 5 m. Whatever looks like
// a loop is one tree or one row off somewhere.
TEST(LoopCloserInAGrid, AcceptsNoFalseLoop) {
  int num_tried = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    const PlanarOrchard orchard(GridOrchardOptions(seed));
    PoseGraph graph;
    std::vector<Keyframe> keyframes;
    Submap submap;
    submap.id = SubmapId{0};
    OccupancyGrid grid{OccupancyGridOptions()};
    const SE2 drift = DriftInAGrid(seed);
    const auto add = [&](size_t scan, const SE2& T_map_base) {
      keyframes.push_back({KeyframeId{static_cast<int>(keyframes.size())},
                           ProjectLaserScan(orchard.Scan(scan), ProjectionOptions()), true});
      graph.AddNode(keyframes.back().id, T_map_base);
    };
    const SE2 T_submap_world = orchard.TruePose(20).Inverse();
    for (size_t i = 20; i < 130; i += 2) {
      add(i, orchard.TruePose(i));
      submap.keyframes.push_back(keyframes.back().id);
      grid.Insert(T_submap_world * orchard.TruePose(i), *keyframes.back().scan.Get());
    }
    submap.cells = grid.OccupiedCells(static_cast<float>(LogOddsOf(0.55)));
    graph.AddNode(submap.id, orchard.TruePose(20));
    std::vector<SE2> truth;
    for (size_t i = 21; i < 130; i += 12) {
      add(i, drift * orchard.TruePose(i));
      truth.push_back(T_submap_world * orchard.TruePose(i));
    }
    LoopOptions options;
    options.keyframe_stride = 1;
    const LoopCloser closer(options, {}, Matcher({}, {}, {}), OccupancyGridOptions());
    for (const LoopCandidate& candidate : closer.FindAll(graph, graph, keyframes, {submap}, {}, 2)) {
      ++num_tried;
      if (!candidate.accepted) continue;
      const size_t index = static_cast<size_t>(candidate.keyframe.value) - submap.keyframes.size();
      EXPECT_LT((candidate.match.pose.translation() - truth[index].translation()).norm(), 0.3)
          << "seed " << seed << ", keyframe " << candidate.keyframe.value;
    }
  }
  EXPECT_GE(num_tried, 100);
}

TEST_F(LoopCloserTest, NothingToCloseIsNoError) {
  EXPECT_TRUE(closer_.FindAll(Graph(SE2()), Graph(SE2()), run_.keyframes, {}, {}, 2).empty());
  EXPECT_TRUE(closer_.FindAll(PoseGraph(), PoseGraph(), {}, {}, {}, 1).empty());
}

}  // namespace
}  // namespace arborslam
