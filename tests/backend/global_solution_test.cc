#include "backend/global_solution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/backend/drifted_run.h"

namespace arborslam {
namespace {

double GreatestError(const PoseGraph& graph, const std::vector<SE2>& truth) {
  double greatest = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) {
    const SE2 error = truth[i].Inverse() * graph.Pose(KeyframeId{static_cast<int>(i)});
    greatest = std::max(greatest, error.translation().norm());
  }
  return greatest;
}

class GlobalSolutionTest : public testing::Test {
 protected:
  GlobalSolutionTest() {
    options_.map_refinement.num_passes = 0;
    options_.loop.keyframe_stride = 2;
    options_.loop.max_search_translation = 2.0;
  }

  GlobalSolution Solve(PoseGraph* graph, int num_threads = 2) {
    std::vector<Submap> submaps = drifted_.run.submaps;
    return SolveGlobally(options_, Matcher({}, {}, {}), num_threads, drifted_.run.keyframes, graph, &submaps);
  }

  SlamOptions options_;
  const DriftedRun drifted_;
};

TEST_F(GlobalSolutionTest, ClosesWhatHasDriftedBeyondAllWindows) {
  PoseGraph graph = drifted_.Graph(SE2(7.0, -6.0, 0.2), {10.0, 10.0, 0.5});
  const GlobalSolution solution = Solve(&graph);
  EXPECT_GE(solution.num_loop_searches, 3u) << "near, after drift, near again";
  EXPECT_LT(GreatestError(graph, drifted_.run.truth), 0.05);
}

TEST_F(GlobalSolutionTest, LoopsThatCountAreThoseOfTheGraph) {
  PoseGraph graph = drifted_.Graph(SE2(7.0, -6.0, 0.2), {10.0, 10.0, 0.5});
  const GlobalSolution solution = Solve(&graph);
  size_t num_accepted = 0;
  for (size_t i = 0; i < solution.loops.size(); ++i) {
    const LoopCandidate& loop = solution.loops[i];
    EXPECT_EQ(loop.accepted, loop.reason.empty());
    num_accepted += loop.accepted ? 1 : 0;
    for (size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(solution.loops[j].keyframe == loop.keyframe && solution.loops[j].submap == loop.submap);
    }
  }
  size_t num_in_graph = 0;
  for (const Constraint& constraint : graph.constraints()) {
    num_in_graph += constraint.kind == Constraint::Kind::kLoop ? 1 : 0;
  }
  EXPECT_EQ(num_accepted, num_in_graph);
  EXPECT_GE(num_accepted, 10u);
}

TEST_F(GlobalSolutionTest, DropsWeakLoopsThatTheOthersContradict) {
  PoseGraph graph = drifted_.Graph(SE2(0.5, 0.0, 0.0), {1.0, 1.0, 0.1});
  const auto add = [&](int keyframe, const SE2& error, const Eigen::Vector3d& information) {
    const SE2 T_submap_keyframe =
        drifted_.run.truth.front().Inverse() * drifted_.run.truth[static_cast<size_t>(keyframe)];
    graph.AddConstraint({SubmapId{0}, KeyframeId{keyframe}, T_submap_keyframe * error, information.asDiagonal(),
                         Constraint::Kind::kLoop});
  };
  // Eight standard deviations, less than the gate.
  add(30, SE2(0.8, 0.0, 0.0), {100.0, 1e4, 1e4});
  // Off in a direction that it leaves open.
  add(32, SE2(0.8, 0.0, 0.0), {0.0, 1e4, 1e4});
  Solve(&graph);
  const auto has_loop = [&](int keyframe) {
    return std::any_of(graph.constraints().begin(), graph.constraints().end(), [&](const Constraint& constraint) {
      return constraint.kind == Constraint::Kind::kLoop && constraint.from == NodeId(SubmapId{0}) &&
             constraint.to == NodeId(KeyframeId{keyframe});
    });
  };
  EXPECT_FALSE(has_loop(30));
  EXPECT_TRUE(has_loop(32));
  EXPECT_LT(GreatestError(graph, drifted_.run.truth), 0.05);
}

TEST_F(GlobalSolutionTest, TheSameForAnyNumberOfThreads) {
  PoseGraph one = drifted_.Graph(SE2(7.0, -6.0, 0.2), {10.0, 10.0, 0.5});
  PoseGraph three = one;
  Solve(&one, 1);
  Solve(&three, 3);
  for (size_t i = 0; i < drifted_.run.truth.size(); ++i) {
    const KeyframeId id{static_cast<int>(i)};
    EXPECT_EQ(one.Pose(id).vector(), three.Pose(id).vector());
  }
}

TEST_F(GlobalSolutionTest, WithoutVotesOnDriftItStaysWhereItIs) {
  options_.loop.drift_votes = 0;
  PoseGraph graph = drifted_.Graph(SE2(7.0, -6.0, 0.2), {10.0, 10.0, 0.5});
  Solve(&graph);
  EXPECT_GT(GreatestError(graph, drifted_.run.truth), 4.0);
}

}  // namespace
}  // namespace arborslam
