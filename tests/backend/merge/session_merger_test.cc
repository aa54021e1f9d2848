// Sessions of one site and of different sites, with exact ground truth.

#include "backend/merge/session_merger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "backend/run_outputs.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/binary_archive.h"
#include "core/simulation/orchard.h"
#include "core/simulation/simulated_run.h"
#include "tests/backend/session_of_run.h"

namespace arborslam {
namespace {

PlanarOrchardOptions OrchardOptionsOf(int seed) {
  PlanarOrchardOptions options;
  options.seed = seed;
  options.rows = 3;
  options.trees_per_row = 9;
  return options;
}

std::vector<LaserScan> ScansOf(const PlanarOrchard& orchard) {
  std::vector<LaserScan> scans;
  for (size_t i = 0; i < orchard.NumScans(); ++i) scans.push_back(orchard.Scan(i));
  return scans;
}

SessionMerger MergerOf(const SessionContents& first, int num_threads = 1) {
  return SessionMerger(SlamOptions(), MergeOptions(), num_threads, first);
}

template <class Value>
std::string BytesOf(const Value& value) {
  BinaryWriter writer;
  writer(value);
  return writer.bytes();
}

// Two walks through one orchard, the second one the other way around and beginning elsewhere.
class SessionMergerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    orchard_ = new PlanarOrchard(OrchardOptionsOf(2));
    const auto last = static_cast<int>(orchard_->NumScans()) - 1;
    back_ = new OtherWalk(*orchard_, last * 3 / 4, 0, 0.1, 7, -100.0);
    a_ = new SessionContents(SessionOf(ScansOf(*orchard_), "a"));
    b_ = new SessionContents(SessionOf(back_->scans, "b"));
  }
  static void TearDownTestSuite() {
    delete b_;
    delete a_;
    delete back_;
    delete orchard_;
  }

  // T_world_base of all scans, in the order of the merged session.
  static std::vector<SE2> TruthOfBoth() {
    std::vector<SE2> truth;
    for (size_t i = 0; i < orchard_->NumScans(); ++i) truth.push_back(orchard_->TruePose(i));
    truth.insert(truth.end(), back_->truth.begin(), back_->truth.end());
    return truth;
  }

  static PlanarOrchard* orchard_;
  static OtherWalk* back_;
  static SessionContents* a_;
  static SessionContents* b_;
};

PlanarOrchard* SessionMergerTest::orchard_ = nullptr;
OtherWalk* SessionMergerTest::back_ = nullptr;
SessionContents* SessionMergerTest::a_ = nullptr;
SessionContents* SessionMergerTest::b_ = nullptr;

TEST_F(SessionMergerTest, FindsHowTwoMapsOfOneOrchardLie) {
  SessionMerger merger = MergerOf(*a_);
  const PlaceVotes votes = merger.Add(*b_);
  ASSERT_EQ(votes.reason, "");
  EXPECT_GT(votes.agreeing.size(), votes.num_asked / 4);
  EXPECT_LE(votes.num_rivals, 1u);
  // Each map begins at the first pose of its walk, with the bend that it has.
  const SE2 truth = orchard_->TruePose(0).Inverse() * back_->truth.front();
  const SE2 error = truth.Inverse() * votes.T_a_b;
  EXPECT_LT(error.translation().norm(), 0.15) << error;
  EXPECT_LT(std::abs(error.theta()), 0.01) << error;

  const MergeSolution solution = merger.Finish();
  EXPECT_FALSE(solution.loops.empty());
  EXPECT_EQ(solution.refinements.size(), static_cast<size_t>(MapRefinementOptions().num_passes));
  // All scans of both in one frame, without any alignment but that of the map's frame.
  const SessionContents& merged = merger.merged();
  const std::vector<SE2> all_truth = TruthOfBoth();
  ASSERT_EQ(merged.scans.size(), all_truth.size());
  std::vector<PosePair> pairs;
  const Trajectory3 estimate = ToTrajectory3(TrajectoryOf(merged.graph, merged.scans));
  for (size_t i = 0; i < all_truth.size(); ++i) {
    const Trajectory3 reference = ToTrajectory3(Trajectory{{estimate.poses[i].stamp, all_truth[i]}});
    pairs.push_back({estimate.poses[i], reference.poses.front()});
  }
  const TrajectoryEvaluation evaluation = EvaluateTrajectory(pairs, true, AlignmentKind::kSe2);
  EXPECT_LT(evaluation.metrics.ate_rmse, 0.05);
  EXPECT_LT(evaluation.metrics.ate_max, 0.3);
}

TEST_F(SessionMergerTest, HoldsAllOfBothAndCountsOn) {
  SessionMerger merger = MergerOf(*a_);
  ASSERT_EQ(merger.Add(*b_).reason, "");
  const MergeSolution solution = merger.Finish();
  const SessionContents& merged = merger.merged();
  EXPECT_TRUE(merged.is_finished);
  EXPECT_TRUE(merged.state.empty());
  ASSERT_EQ(merged.recordings.size(), 2u);
  EXPECT_EQ(merged.recordings[0].name, "a");
  EXPECT_EQ(merged.recordings[1].name, "b");
  EXPECT_EQ(merged.recordings[1].num_read, b_->read.size());
  EXPECT_EQ(merged.recordings[1].num_posed, b_->scans.size());
  ASSERT_EQ(merged.read.size(), a_->read.size() + b_->read.size());
  ASSERT_EQ(merged.scans.size(), a_->scans.size() + b_->scans.size());
  ASSERT_EQ(merged.keyframes.size(), a_->keyframes.size() + b_->keyframes.size());
  ASSERT_EQ(merged.submaps.size(), a_->submaps.size() + b_->submaps.size());
  ASSERT_EQ(merged.graph.poses().size(), a_->graph.poses().size() + b_->graph.poses().size());
  for (size_t i = 0; i < b_->scans.size(); ++i) {
    const PosedScan& scan = merged.scans[a_->scans.size() + i];
    EXPECT_EQ(scan.stamp, b_->scans[i].stamp);
    EXPECT_EQ(scan.keyframe.value, b_->scans[i].keyframe.value + static_cast<int>(a_->keyframes.size()));
  }
  for (size_t i = 0; i < merged.keyframes.size(); ++i) {
    EXPECT_EQ(merged.keyframes[i].id.value, static_cast<int>(i));
    const Keyframe& original = i < a_->keyframes.size() ? a_->keyframes[i] : b_->keyframes[i - a_->keyframes.size()];
    EXPECT_EQ(BytesOf(merged.keyframes[i].scan), BytesOf(original.scan));
  }
  // A submap is of one session, and every one has a pose.
  std::set<int> submaps;
  const auto is_of_a = [](KeyframeId id) { return static_cast<size_t>(id.value) < a_->keyframes.size(); };
  for (const Submap& submap : merged.submaps) {
    EXPECT_TRUE(submaps.insert(submap.id.value).second);
    EXPECT_EQ(merged.graph.poses().count(submap.id), 1u);
    EXPECT_EQ(is_of_a(submap.keyframes.front()), is_of_a(submap.keyframes.back()));
  }
  // Loops from one to the other, counted one by one.
  std::map<int, bool> submap_is_of_a;
  for (const Submap& submap : merged.submaps) submap_is_of_a[submap.id.value] = is_of_a(submap.keyframes.front());
  size_t num_tried = 0;
  size_t num_accepted = 0;
  for (const LoopCandidate& loop : solution.loops) {
    if (submap_is_of_a.at(loop.submap.value) == is_of_a(loop.keyframe)) continue;
    ++num_tried;
    num_accepted += loop.accepted ? 1 : 0;
  }
  EXPECT_GT(num_accepted, 0u);
  EXPECT_EQ(solution.num_cross_tried, num_tried);
  EXPECT_EQ(solution.num_cross_accepted, num_accepted);
  // Within one session none is across.
  EXPECT_EQ(MergerOf(*a_).Finish().num_cross_tried, 0u);
  // Each recording has a trajectory of its own.
  const std::vector<Trajectory3> trajectories = TrajectoriesOf(merged);
  ASSERT_EQ(trajectories.size(), 2u);
  EXPECT_EQ(trajectories[0].poses.size(), a_->scans.size());
  ASSERT_EQ(trajectories[1].poses.size(), b_->scans.size());
  EXPECT_EQ(trajectories[1].poses.front().stamp, b_->scans.front().stamp);
  EXPECT_EQ(trajectories[1].poses.back().position, Trajectory3Of(merged.graph, merged.scans).poses.back().position);
  // The motion is that of the runs: none leads from one to the other.
  for (const Constraint& constraint : merged.graph.constraints()) {
    if (constraint.kind != Constraint::Kind::kMotion) continue;
    EXPECT_EQ(is_of_a(KeyframeId{constraint.from.value}), is_of_a(KeyframeId{constraint.to.value}));
  }
}

TEST_F(SessionMergerTest, IsTheSameForAnyNumberOfThreads) {
  SessionMerger one = MergerOf(*a_, 1);
  SessionMerger three = MergerOf(*a_, 3);
  EXPECT_EQ(one.Add(*b_).agreeing.size(), three.Add(*b_).agreeing.size());
  one.Finish();
  three.Finish();
  EXPECT_EQ(BytesOf(one.merged().graph.poses()), BytesOf(three.merged().graph.poses()));
  EXPECT_EQ(BytesOf(one.merged().submaps), BytesOf(three.merged().submaps));
}

TEST_F(SessionMergerTest, TakesAThirdSessionInTheMapOfTwo) {
  // A stretch of its own, which begins in the middle of a row.
  const OtherWalk third(*orchard_, 20, 75, 0.1, 9, 5000.0);
  SessionMerger merger = MergerOf(*b_);
  ASSERT_EQ(merger.Add(*a_).reason, "");
  const PlaceVotes votes = merger.Add(SessionOf(third.scans, "c"));
  ASSERT_EQ(votes.reason, "");
  merger.Finish();
  const SessionContents& merged = merger.merged();
  ASSERT_EQ(merged.recordings.size(), 3u);
  const size_t first = a_->scans.size() + b_->scans.size();
  const Trajectory trajectory = TrajectoryOf(merged.graph, merged.scans);
  ASSERT_EQ(trajectory.size(), first + third.scans.size());
  for (size_t i = 0; i < third.scans.size(); ++i) {
    EXPECT_EQ(trajectory[first + i].stamp, third.scans[i].stamp);
    const SE2 error = (back_->truth.front().Inverse() * third.truth[i]).Inverse() * trajectory[first + i].pose;
    EXPECT_LT(error.translation().norm(), 0.3) << i << " " << error;
  }
}

TEST_F(SessionMergerTest, RefusesAnotherOrchardAndStaysAsItIs) {
  for (const int seed : {1, 3, 4}) {
    SCOPED_TRACE(seed);
    const SessionContents other = SessionOf(ScansOf(PlanarOrchard(OrchardOptionsOf(seed))), "other");
    SessionMerger merger = MergerOf(*a_);
    const PlaceVotes votes = merger.Add(other);
    EXPECT_EQ(votes.reason, "too few agree");
    EXPECT_LT(votes.agreeing.size(), static_cast<size_t>(MergeOptions().min_votes));
    EXPECT_GT(votes.num_asked, 20u);
    EXPECT_EQ(merger.merged().recordings.size(), 1u);
    EXPECT_EQ(BytesOf(merger.merged().graph.poses()), BytesOf(a_->graph.poses()));
  }
}

TEST_F(SessionMergerTest, RefusesWhatRepeatsItself) {
  // Every tree is like any other one, as far as one can see.
  PlanarOrchardOptions options = IdealPlanarOrchardOptions();
  options.rows = 4;
  const PlanarOrchard orchard(options);
  const auto last = static_cast<int>(orchard.NumScans()) - 1;
  const OtherWalk there(orchard, 0, last, 0.2, 7, 0.0);
  const OtherWalk back(orchard, last, 0, 0.3, 8, 0.0);
  SessionMerger merger = MergerOf(SessionOf(there.scans, "there"));
  const PlaceVotes votes = merger.Add(SessionOf(back.scans, "back"));
  if (!votes.reason.empty()) return SUCCEED() << votes.reason;
  // Where an end of the grid is in sight it may be found, but only right.
  const SE2 error = (there.truth.front().Inverse() * back.truth.front()).Inverse() * votes.T_a_b;
  EXPECT_LT(error.translation().norm(), 0.5);
}

TEST(SessionMergerSpatialTest, GroundThatBothSawLiesAtOneHeight) {
  // One walk in two halves that overlap, the second one begun where the ground lies higher or lower.
  OrchardOptions options;
  options.run.seed = 5;
  const SimulatedRun run(options.run, MakeOrchard(options));
  const auto sweeps_of = [&run](size_t first, size_t last) {
    std::vector<LidarSweep> sweeps;
    for (size_t i = first; i < last; i += 2) sweeps.push_back(run.Sweep(i));
    return sweeps;
  };
  const SessionContents a = SessionOf(sweeps_of(0, 240), "a");
  const SessionContents b = SessionOf(sweeps_of(101, 341), "b");
  SessionMerger merger = MergerOf(a);
  ASSERT_EQ(merger.Add(b).reason, "");
  merger.Finish();
  const SessionContents& merged = merger.merged();
  ASSERT_EQ(merged.scans.size(), a.scans.size() + b.scans.size());
  const Trajectory3 trajectory = Trajectory3Of(merged.graph, merged.scans);
  double before = 0.0;
  double after = 0.0;
  for (size_t i = 0; i < merged.scans.size(); ++i) {
    const size_t sweep = i < a.scans.size() ? 2 * i : 101 + 2 * (i - a.scans.size());
    const double z = run.TruePose(sweep).translation().z() - run.TruePose(0).translation().z();
    const double start = trajectory.poses.front().position.z();
    EXPECT_NEAR(trajectory.poses[i].position.z() - start, z, 0.5) << i;
    if (i < a.scans.size() || sweep >= 240) continue;
    // Its partner in the other session was taken between these two.
    const size_t partner = (sweep - 1) / 2;
    after = std::max(after, std::abs(trajectory.poses[i].position.z() - trajectory.poses[partner].position.z()));
    const PosedScan& alone = b.scans[i - a.scans.size()];
    before = std::max(before, std::abs(alone.tilt.z - a.scans[partner].tilt.z));
  }
  EXPECT_LT(after, 0.1);
  EXPECT_GT(before, after);
}

}  // namespace
}  // namespace arborslam
