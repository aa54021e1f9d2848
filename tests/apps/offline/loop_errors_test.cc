#include "apps/offline/loop_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/geometry/se2.h"
#include "core/sensor/trajectory3.h"

namespace arborslam {
namespace {

// A submap begun at keyframe 0, and keyframes 5 and 6 that see it; keyframe i was at (i, 1, 0.1 i).
class LoopErrorsTest : public testing::Test {
 protected:
  LoopErrorsTest() {
    submaps_.push_back({SubmapId{0}, {KeyframeId{0}, KeyframeId{1}}, {}});
    graph_.AddNode(SubmapId{0}, TruePose(0));
    for (int i = 0; i < 7; ++i) {
      graph_.AddNode(KeyframeId{i}, TruePose(i));
      PosedScan scan;
      scan.stamp = 10.0 + i;
      scan.keyframe = KeyframeId{i};
      scans_.push_back(scan);
      // One more scan hangs on the keyframe, elsewhere.
      scan.stamp += 0.5;
      scans_.push_back(scan);
      AddTruth(10.0 + i, TruePose(i));
      AddTruth(10.5 + i, SE2(50.0, 50.0, 1.0));
    }
  }

  static SE2 TruePose(int keyframe) { return SE2(keyframe, 1.0, 0.1 * keyframe); }

  void AddTruth(double stamp, const SE2& pose) {
    PosePair pair;
    // The reference's own stamps may differ a little.
    pair.reference = Lifted({stamp + 0.01, pose}, Tilt3());
    pair.estimate.stamp = stamp;
    pairs_.push_back(pair);
  }

  // A loop that is off by `error` in the keyframe's frame.
  LoopCandidate Loop(int keyframe, const SE2& error, bool accepted) const {
    LoopCandidate loop;
    loop.keyframe = KeyframeId{keyframe};
    loop.submap = SubmapId{0};
    loop.match.pose = TruePose(0).Inverse() * TruePose(keyframe) * error;
    loop.accepted = accepted;
    return loop;
  }

  std::vector<Submap> submaps_;
  std::vector<PosedScan> scans_;
  PoseGraph graph_;
  std::vector<PosePair> pairs_;
};

TEST_F(LoopErrorsTest, TellsTrueFromFalse) {
  const LoopErrors errors = EvaluateLoops({Loop(5, SE2(0.03, 0.04, 0.01), true), Loop(6, SE2(0.0, 1.2, 0.0), true),
                                           Loop(6, SE2(0.0, 0.0, 0.2), true), Loop(5, SE2(0.0, 0.0, 0.0), false)},
                                          submaps_, scans_, graph_, pairs_);
  EXPECT_EQ(errors.num_tried, 4u);
  EXPECT_EQ(errors.num_accepted, 3u);
  EXPECT_EQ(errors.num_false, 2u);
  EXPECT_NEAR(errors.translation_max, 1.2, 1e-9);
  EXPECT_NEAR(errors.translation_rms, std::sqrt((0.05 * 0.05 + 1.2 * 1.2) / 3.0), 1e-9);
  EXPECT_NEAR(errors.Precision(), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(errors.Recall(), 1.0 / 4.0, 1e-12);
}

// A heading that is off at the submap's begin turns its frame, and with it every place far off.
TEST_F(LoopErrorsTest, ComparesFromTheNearestKeyframe) {
  PoseGraph turned;
  const SE2 error(0.0, 0.0, 0.2);
  turned.AddNode(SubmapId{0}, TruePose(0) * error);
  turned.AddNode(KeyframeId{0}, TruePose(0) * error);
  turned.AddNode(KeyframeId{1}, TruePose(1));
  LoopCandidate loop = Loop(5, SE2(), true);
  loop.match.pose = error.Inverse() * loop.match.pose;
  const LoopErrors errors = EvaluateLoops({loop}, submaps_, scans_, turned, pairs_);
  EXPECT_EQ(errors.num_false, 0u);
  EXPECT_NEAR(errors.translation_max, 0.0, 1e-9);
}

TEST_F(LoopErrorsTest, LeavesOutWhatTheReferenceDoesNotKnow) {
  std::vector<PosePair> without_six;
  for (const PosePair& pair : pairs_) {
    if (pair.estimate.stamp != 16.0) without_six.push_back(pair);
  }
  const std::vector<LoopCandidate> loops = {Loop(5, SE2(), true), Loop(6, SE2(9.0, 0.0, 0.0), true)};
  EXPECT_EQ(EvaluateLoops(loops, submaps_, scans_, graph_, without_six).num_tried, 1u);
  EXPECT_EQ(EvaluateLoops(loops, submaps_, scans_, graph_, without_six).num_false, 0u);
  // Nor a submap none of whose keyframes is known.
  const std::vector<PosePair> late(pairs_.begin() + 4, pairs_.end());
  EXPECT_EQ(EvaluateLoops(loops, submaps_, scans_, graph_, late).num_tried, 0u);
}

TEST_F(LoopErrorsTest, FindsNothingWrongWithNoLoops) {
  const LoopErrors errors = EvaluateLoops({}, submaps_, scans_, graph_, pairs_);
  EXPECT_EQ(errors.num_tried, 0u);
  EXPECT_EQ(errors.Precision(), 1.0);
  EXPECT_EQ(errors.Recall(), 1.0);
  EXPECT_EQ(errors.translation_rms, 0.0);
}

}  // namespace
}  // namespace arborslam
