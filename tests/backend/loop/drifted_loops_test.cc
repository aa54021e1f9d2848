#include "backend/loop/drifted_loops.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

#include "frontend/projection/laser_projection.h"
#include "tests/backend/drifted_run.h"
#include "tests/backend/grid_orchard.h"

namespace arborslam {
namespace {

DriftedLoopFinder Finder(const LoopOptions& options) {
  return {options, PlaceOptions(), MatcherOptions(), Matcher({}, {}, {}), 0.05};
}

// The chain of submaps is believed to know every direction to a metre and a radian: windows of 3 m and more follow.
LoopOptions NarrowWindows() {
  LoopOptions options;
  options.max_search_translation = 2.0;
  return options;
}

size_t NumAccepted(const std::vector<LoopCandidate>& loops) {
  size_t count = 0;
  for (const LoopCandidate& loop : loops) count += loop.accepted ? 1 : 0;
  return count;
}

const Eigen::Vector3d kUnsure(10.0, 10.0, 0.5);

class DriftedLoopFinderTest : public testing::Test {
 protected:
  std::vector<LoopCandidate> Find(const LoopOptions& options, const PoseGraph& graph, int num_threads = 2) const {
    return Finder(options).FindAll(graph, drifted_.run.keyframes, drifted_.run.submaps, num_threads);
  }

  const DriftedRun drifted_;
  const SE2 drift_{7.0, -6.0, 0.2};
};

TEST_F(DriftedLoopFinderTest, FindsTheTruthBeyondAllWindows) {
  const std::vector<LoopCandidate> loops = Find(NarrowWindows(), drifted_.Graph(drift_, kUnsure));
  EXPECT_GE(NumAccepted(loops), 10u);
  for (const LoopCandidate& loop : loops) {
    if (!loop.accepted) continue;
    const std::vector<SE2>& truth = drifted_.run.truth;
    const Submap& submap = drifted_.run.submaps[static_cast<size_t>(loop.submap.value)];
    const SE2 expected = drifted_.run.TruthOf(submap).Inverse() * truth[static_cast<size_t>(loop.keyframe.value)];
    EXPECT_LT((loop.match.pose.translation() - expected.translation()).norm(), 0.05) << loop.keyframe.value;
    EXPECT_GT((loop.prediction.translation() - expected.translation()).norm(), 4.0);
    EXPECT_GT(loop.search_translation, 2.0);
  }
}

TEST_F(DriftedLoopFinderTest, TheSameForAnyNumberOfThreads) {
  const PoseGraph graph = drifted_.Graph(drift_, kUnsure);
  const std::vector<LoopCandidate> one = Find(NarrowWindows(), graph, 1);
  const std::vector<LoopCandidate> three = Find(NarrowWindows(), graph, 3);
  ASSERT_EQ(one.size(), three.size());
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].keyframe, three[i].keyframe);
    EXPECT_EQ(one[i].submap, three[i].submap);
    EXPECT_EQ(one[i].match.pose.vector(), three[i].match.pose.vector());
    EXPECT_EQ(one[i].reason, three[i].reason);
  }
}

TEST_F(DriftedLoopFinderTest, AsksNothingWhereWindowsReach) {
  LoopOptions wide = NarrowWindows();
  wide.max_search_translation = 50.0;
  wide.max_search_rotation = 3.15;
  EXPECT_TRUE(Find(wide, drifted_.Graph(drift_, {1.0, 1.0, 0.1})).empty());
}

TEST_F(DriftedLoopFinderTest, AsksNothingWhereALoopJoinsThePieces) {
  PoseGraph graph = drifted_.Graph(drift_, kUnsure);
  graph.AddConstraint({SubmapId{0}, KeyframeId{30}, SE2(), Eigen::Matrix3d::Identity(), Constraint::Kind::kLoop});
  EXPECT_TRUE(Find(NarrowWindows(), graph).empty());
}

TEST_F(DriftedLoopFinderTest, RefusesWhatTooFewAgreeOn) {
  LoopOptions options = NarrowWindows();
  options.drift_votes = 1000;
  const std::vector<LoopCandidate> loops = Find(options, drifted_.Graph(drift_, kUnsure));
  EXPECT_GE(loops.size(), 10u);
  for (const LoopCandidate& loop : loops) {
    EXPECT_FALSE(loop.accepted);
    EXPECT_EQ(loop.reason, "too few agree");
  }
  options.drift_votes = 0;
  EXPECT_TRUE(Find(options, drifted_.Graph(drift_, kUnsure)).empty());
}

TEST_F(DriftedLoopFinderTest, RefusesATurnThatTheCovarianceCannotExplain) {
  // The chain of submaps knows the heading to a hundredth of a radian.
  const PoseGraph graph = drifted_.Graph(SE2(7.0, -6.0, 2.0), {10.0, 10.0, 0.01});
  const std::vector<LoopCandidate> loops = Find(NarrowWindows(), graph);
  EXPECT_GE(loops.size(), 5u);
  EXPECT_EQ(NumAccepted(loops), 0u);
}

TEST_F(DriftedLoopFinderTest, RecognisesNothingInAnotherWorld) {
  PostsRun other(StrewnPosts(60, 40.0, 4), DriftedRun::Path());
  std::vector<Keyframe> keyframes = drifted_.run.keyframes;
  for (size_t i = 20; i < keyframes.size(); ++i) keyframes[i] = other.keyframes[i];
  const PoseGraph graph = drifted_.Graph(drift_, kUnsure);
  EXPECT_EQ(NumAccepted(Finder(NarrowWindows()).FindAll(graph, keyframes, drifted_.run.submaps, 2)), 0u);
}

TEST_F(DriftedLoopFinderTest, NothingToCloseIsNoError) {
  EXPECT_TRUE(Finder({}).FindAll(PoseGraph(), {}, {}, 1).empty());
  EXPECT_TRUE(Finder({}).FindAll(drifted_.Graph(drift_, kUnsure), drifted_.run.keyframes, {}, 2).empty());
}

// Equal trees on an exact grid, walked through twice; the second time has drifted by 5 m and the graph knows that it
// may have. Single answers may be a tree or a row off, but no such loop may count.
TEST(DriftedLoopFinderInAGrid, AcceptsNoFalseLoop) {
  for (int seed = 1; seed <= 6; ++seed) {
    const PlanarOrchard orchard(GridOrchardOptions(seed));
    const SE2 drift = DriftInAGrid(seed);
    PoseGraph graph;
    std::vector<Keyframe> keyframes;
    std::vector<Submap> submaps(2);
    const SE2 T_submap_world = orchard.TruePose(20).Inverse();
    OccupancyGrid grid{OccupancyGridOptions()};
    const Eigen::Matrix3d sure = Eigen::Vector3d(1e4, 1e4, 1e6).asDiagonal();
    for (int pass = 0; pass < 2; ++pass) {
      Submap& submap = submaps[static_cast<size_t>(pass)];
      submap.id = SubmapId{pass};
      const SE2 shift = pass == 0 ? SE2() : drift;
      graph.AddNode(submap.id, shift * orchard.TruePose(20));
      for (size_t i = pass == 0 ? 20 : 21; i < 130; i += pass == 0 ? 2 : 6) {
        const KeyframeId id{static_cast<int>(keyframes.size())};
        keyframes.push_back({id, ProjectLaserScan(orchard.Scan(i), ProjectionOptions()), true});
        graph.AddNode(id, shift * orchard.TruePose(i));
        const SE2 T_submap_base = T_submap_world * orchard.TruePose(i);
        graph.AddConstraint({submap.id, id, T_submap_base, sure, Constraint::Kind::kSubmap});
        submap.keyframes.push_back(id);
        if (pass == 0) grid.Insert(T_submap_base, *keyframes.back().scan.Get());
      }
      submap.cells = grid.OccupiedCells(static_cast<float>(LogOddsOf(0.55)));
    }
    const KeyframeId first_again = submaps[1].keyframes.front();
    graph.AddConstraint({SubmapId{0}, first_again, graph.Pose(SubmapId{0}).Inverse() * graph.Pose(first_again),
                         Eigen::Vector3d(0.01, 0.01, 4.0).asDiagonal(), Constraint::Kind::kSubmap});
    LoopOptions options = NarrowWindows();
    options.drift_votes = 2;  // Fewer than by default, so that there is something to refuse.
    for (const LoopCandidate& loop : Finder(options).FindAll(graph, keyframes, submaps, 2)) {
      if (!loop.accepted || !(loop.submap == SubmapId{0})) continue;
      const SE2 truth = T_submap_world * drift.Inverse() * graph.Pose(loop.keyframe);
      EXPECT_LT((loop.match.pose.translation() - truth.translation()).norm(), 0.3)
          << "seed " << seed << ", keyframe " << loop.keyframe.value;
    }
  }
}

}  // namespace
}  // namespace arborslam
