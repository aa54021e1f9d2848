#include "frontend/tracking/tracker.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "frontend/tracking/motion_model.h"
#include "tests/frontend/simulated_run.h"

namespace arborslam {
namespace {

Tracker MakeTracker(const TrackerOptions& options) {
  return Tracker(options, OccupancyGridOptions(), kTestMaxDistance,
                 Matcher(MatcherOptions(), MhdOptions(), RefinementOptions()));
}

PlanarScan Project(const PlanarOrchard& orchard, size_t index) {
  return ProjectLaserScan(orchard.Scan(index), ProjectionOptions());
}

PlanarOrchardOptions WithSeed(int seed, double spoilt_scans) {
  PlanarOrchardOptions options;
  options.seed = seed;
  options.spoilt_scans = spoilt_scans;
  return options;
}

// Inserts `count` scans from `first` on at their true poses.
void Build(const PlanarOrchard& orchard, size_t first, size_t count, Tracker* tracker) {
  for (size_t i = first; i < first + count; ++i) {
    tracker->Insert(KeyframeId{static_cast<int>(i)}, Project(orchard, i), orchard.TruePose(i));
  }
}

// A scan with one point, for tests that need none.
PlanarScan OnePoint() {
  PlanarScan scan;
  scan.points = {Eigen::Vector2f(2.0f, 0.0f)};
  return scan;
}

TEST(TrackerTest, TracksAnOrchardOnItsOwn) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  Tracker tracker = MakeTracker(TrackerOptions());
  std::vector<StampedPose> poses;
  int num_measured_twice = 0;
  for (size_t i = 0; i < 90; ++i) {
    const PlanarScan scan = Project(orchard, i);
    const SE2 truth = orchard.TruePose(0).Inverse() * orchard.TruePose(i);
    SE2 pose;
    if (i > 0) {
      const SE2 prediction =
          i == 1 ? poses.back().pose : PredictPose(poses[i - 2], poses[i - 1], scan.stamp, MotionOptions());
      const TrackingResult result = tracker.Track(scan.points, poses.back().pose, prediction);
      ASSERT_TRUE(IsUsable(result.match.verdict)) << "scan " << i << ": " << ToString(result.match.verdict);
      ASSERT_FALSE(result.measurements.empty());
      pose = result.match.pose;
      EXPECT_TRUE((tracker.SubmapPose(result.measurements[0].submap) * result.measurements[0].T_submap_base)
                      .IsApprox(pose, 1e-9));
      if (result.measurements.size() == 2) {
        ++num_measured_twice;
        const SE2 other = tracker.SubmapPose(result.measurements[1].submap) * result.measurements[1].T_submap_base;
        EXPECT_TRUE(other.IsApprox(pose, 0.1));
      }
    }
    EXPECT_LT((pose.translation() - truth.translation()).norm(), 0.3) << "scan " << i;
    EXPECT_LT(std::abs(AngleDifference(pose.theta(), truth.theta())), 0.03) << "scan " << i;
    poses.push_back({scan.stamp, pose});
    tracker.Insert(KeyframeId{static_cast<int>(i)}, scan, pose);
  }
  EXPECT_EQ(tracker.ActiveSubmaps().size(), 1u) << "25 m are less than half a submap";
  EXPECT_EQ(num_measured_twice, 0);
}

// Points that a wrong velocity has bent, and that the match's pose makes straight.
TEST(TrackerTest, MatchesAgainWhatThePoseImproves) {
  const PlanarOrchard orchard(WithSeed(5, 0.0));
  const std::vector<Eigen::Vector2f> points = Project(orchard, 20).points;
  std::vector<Eigen::Vector2f> bent = points;
  for (Eigen::Vector2f& point : bent) point.x() += point.y() > 0.0f ? 0.06f : 0.02f;
  const SE2 last = orchard.TruePose(19);
  const SE2 truth = orchard.TruePose(20);
  Tracker tracker = MakeTracker(TrackerOptions());
  Build(orchard, 0, 20, &tracker);
  const TrackingResult straight = tracker.Track(points, last, truth);
  const TrackingResult crooked = tracker.Track(bent, last, truth);
  std::vector<SE2> asked;
  const TrackingResult improved = tracker.Track(
      bent, last, truth, true, Eigen::Vector3d::Ones(), false, [&](const SE2& pose) -> const auto& {
        asked.push_back(pose);
        return points;
      });
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_TRUE(improved.is_improved);
  EXPECT_FALSE(crooked.is_improved);
  EXPECT_EQ(asked[0].translation(), crooked.match.pose.translation());
  EXPECT_GT((crooked.match.pose.translation() - straight.match.pose.translation()).norm(), 0.02);
  EXPECT_LT((improved.match.pose.translation() - straight.match.pose.translation()).norm(), 0.01);
  EXPECT_LT(improved.match.score, crooked.match.score);
  ASSERT_FALSE(improved.measurements.empty());
  const TrackingResult::Measurement& measured = improved.measurements.front();
  EXPECT_LT(
      ((tracker.SubmapPose(measured.submap) * measured.T_submap_base).translation() - improved.match.pose.translation())
          .norm(),
      1e-9);
  // Improved to something that fits nowhere, it stays as it was.
  const std::vector<Eigen::Vector2f> nothing;
  const TrackingResult spoilt = tracker.Track(
      bent, last, truth, true, Eigen::Vector3d::Ones(), false, [&](const SE2&) -> const auto& { return nothing; });
  EXPECT_FALSE(spoilt.is_improved);
  EXPECT_LT((spoilt.match.pose.translation() - crooked.match.pose.translation()).norm(), 0.005);
  EXPECT_GT(spoilt.match.information.trace(), 0.5 * crooked.match.information.trace());
  // Nor by what fits, but much worse.
  std::vector<Eigen::Vector2f> worse = points;
  for (size_t i = 0; i < worse.size(); ++i) worse[i] *= i % 2 == 0 ? 1.06f : 0.94f;
  const TrackingResult kept = tracker.Track(
      points, last, truth, true, Eigen::Vector3d::Ones(), false, [&](const SE2&) -> const auto& { return worse; });
  ASSERT_TRUE(IsUsable(tracker.Track(worse, last, truth).match.verdict));
  EXPECT_GT(tracker.Track(worse, last, truth).match.score, 1.5 * straight.match.score);
  EXPECT_FALSE(kept.is_improved);
  EXPECT_NEAR(kept.match.score, straight.match.score, 1e-4);
}

TEST(TrackerTest, MeasuresInBothSubmapsWhereTheyOverlap) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  TrackerOptions options;
  options.submap_length = 12.0;
  Tracker tracker = MakeTracker(options);
  Build(orchard, 0, 30, &tracker);
  ASSERT_EQ(tracker.ActiveSubmaps().size(), 2u);
  const SE2 truth = orchard.TruePose(30);
  const TrackingResult result =
      tracker.Track(Project(orchard, 30).points, orchard.TruePose(29), truth * SE2(0.1, -0.1, 0.03));
  ASSERT_EQ(result.measurements.size(), 2u);
  EXPECT_TRUE(result.insert);
  EXPECT_FALSE(result.searched_wide);
  for (const TrackingResult::Measurement& measurement : result.measurements) {
    const SE2 pose = tracker.SubmapPose(measurement.submap) * measurement.T_submap_base;
    EXPECT_LT((pose.translation() - truth.translation()).norm(), 0.06);
    EXPECT_GT(measurement.information(0, 0), 0.0);
  }
  EXPECT_FALSE(result.measurements[0].submap == result.measurements[1].submap);
}

TEST(TrackerTest, WithoutSubmapsThereIsNothingToMatch) {
  Tracker tracker = MakeTracker(TrackerOptions());
  const SE2 prediction(1.0, 2.0, 0.3);
  const TrackingResult result = tracker.Track({Eigen::Vector2f(1.0f, 0.0f)}, SE2(), prediction);
  EXPECT_EQ(result.match.verdict, MatchVerdict::kTooFewPoints);
  EXPECT_TRUE(result.match.pose.IsApprox(prediction));
  EXPECT_TRUE(result.measurements.empty());
  EXPECT_FALSE(result.insert);
  EXPECT_EQ(result.match.num_points, 1);
}

TEST(TrackerTest, AnEmptyScanIsNotMatched) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  Tracker tracker = MakeTracker(TrackerOptions());
  Build(orchard, 0, 10, &tracker);
  const SE2 prediction = orchard.TruePose(10);
  const TrackingResult result = tracker.Track({}, orchard.TruePose(9), prediction);
  EXPECT_EQ(result.match.verdict, MatchVerdict::kTooFewPoints);
  EXPECT_TRUE(result.match.pose.IsApprox(prediction));
  EXPECT_FALSE(result.searched_wide);
  EXPECT_TRUE(result.measurements.empty());
}

TEST(TrackerTest, SubmapsBeginAndFinishAtTheirLengths) {
  TrackerOptions options;
  options.submap_length = 10.0;
  Tracker tracker = MakeTracker(options);
  std::vector<Submap> finished;
  std::vector<int> begun_at;
  int known = 0;
  // A metre a scan, along x.
  for (int i = 0; i <= 32; ++i) {
    const std::optional<Submap> done = tracker.Insert(KeyframeId{i}, OnePoint(), SE2(i, 0.0, 0.0));
    if (done) finished.push_back(*done);
    const std::vector<SubmapId> active = tracker.ActiveSubmaps();
    ASSERT_GE(active.size(), 1u);
    ASSERT_LE(active.size(), 2u);
    if (active.back().value == known) {
      ++known;
      begun_at.push_back(i);
      EXPECT_TRUE(tracker.SubmapPose(active.back()).IsApprox(SE2(i, 0.0, 0.0))) << "anchored at its first scan";
    }
  }
  // The scan after which a submap is 5 m long belongs to it; the next begins a submap.
  EXPECT_EQ(begun_at, (std::vector<int>{0, 6, 12, 18, 24, 30}));
  ASSERT_EQ(finished.size(), 4u);
  for (size_t s = 0; s < finished.size(); ++s) {
    EXPECT_EQ(finished[s].id.value, static_cast<int>(s));
    // Ten metres from its first scan on.
    ASSERT_EQ(finished[s].keyframes.size(), 11u);
    for (size_t k = 0; k < 11; ++k) EXPECT_EQ(finished[s].keyframes[k].value, static_cast<int>(6 * s + k));
  }
  const std::vector<Submap> rest = tracker.FinishAll();
  ASSERT_EQ(rest.size(), 2u);
  EXPECT_EQ(rest[0].id.value, 4);
  EXPECT_EQ(rest[1].keyframes.front().value, 30);
  EXPECT_TRUE(tracker.ActiveSubmaps().empty());
  EXPECT_TRUE(tracker.FinishAll().empty());
}

TEST(TrackerTest, SubmapCellsAreInTheFrameOfTheSubmap) {
  Tracker tracker = MakeTracker(TrackerOptions());
  tracker.Insert(KeyframeId{0}, OnePoint(), SE2(10.0, 5.0, 0.5 * kPi));
  const std::vector<Submap> finished = tracker.FinishAll();
  ASSERT_EQ(finished.size(), 1u);
  const auto cells = finished[0].cells.Get();
  ASSERT_EQ(cells->size(), 1u);
  EXPECT_TRUE(cells->front().centroid.isApprox(Eigen::Vector2f(2.0f, 0.0f), 1e-4f));
}

TEST(TrackerTest, AStandingRobotNeverFinishesASubmap) {
  Tracker tracker = MakeTracker(TrackerOptions());
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(tracker.Insert(KeyframeId{i}, OnePoint(), SE2(0.0, 0.0, 0.1 * i)));
  EXPECT_EQ(tracker.ActiveSubmaps().size(), 1u);
}

TEST(TrackerTest, MatchesFollowASubmapThatIsMoved) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  Tracker tracker = MakeTracker(TrackerOptions());
  Build(orchard, 0, 20, &tracker);
  const SubmapId id = tracker.ActiveSubmaps().front();
  const SE2 correction(0.7, -0.2, 0.3);
  tracker.SetSubmapPose(id, correction * tracker.SubmapPose(id));
  const SE2 moved_truth = correction * orchard.TruePose(20);
  const TrackingResult result = tracker.Track(Project(orchard, 20).points, moved_truth, moved_truth);
  ASSERT_TRUE(IsUsable(result.match.verdict));
  EXPECT_LT((result.match.pose.translation() - moved_truth.translation()).norm(), 0.06);
  EXPECT_LT(std::abs(AngleDifference(result.match.pose.theta(), moved_truth.theta())), 0.01);
}

TEST(TrackerTest, KeyframesAreApartInSpaceOrTime) {
  TrackerOptions options;
  options.keyframe_translation = 0.5;
  options.keyframe_rotation = 0.2;
  options.keyframe_interval = 10.0;
  const Tracker tracker = MakeTracker(options);
  const StampedPose last{100.0, SE2(1.0, 1.0, 3.1)};
  const auto is_keyframe = [&](double stamp, const SE2& motion) {
    return tracker.IsKeyframe(last, {stamp, last.pose * motion});
  };
  EXPECT_FALSE(is_keyframe(100.0, SE2()));
  EXPECT_FALSE(is_keyframe(109.9, SE2(0.3, 0.3, 0.19)));
  EXPECT_TRUE(is_keyframe(100.1, SE2(0.3, 0.41, 0.0)));
  EXPECT_TRUE(is_keyframe(100.1, SE2(0.0, 0.0, 0.21))) << "across the seam at pi";
  EXPECT_TRUE(is_keyframe(100.1, SE2(0.0, 0.0, -0.21)));
  EXPECT_TRUE(is_keyframe(110.0, SE2()));
}

TEST(TrackerTest, SpoiltScansAreKeptOutOfTheMaps) {
  // Half of these scans are spoilt; the maps are made of the others.
  const PlanarOrchard orchard(WithSeed(5, 0.5));
  Tracker tracker = MakeTracker(TrackerOptions());
  int num_spoilt = 0;
  int num_spoilt_inserted = 0;
  int num_clean = 0;
  int num_clean_inserted = 0;
  for (size_t i = 0; i < 90; ++i) {
    const PlanarScan scan = Project(orchard, i);
    if (i >= 20) {
      const TrackingResult result =
          tracker.Track(scan.points, orchard.TruePose(i - 1), orchard.TruePose(i) * SE2(0.05, 0.05, 0.02));
      ++(orchard.IsSpoilt(i) ? num_spoilt : num_clean);
      if (result.insert) ++(orchard.IsSpoilt(i) ? num_spoilt_inserted : num_clean_inserted);
      EXPECT_TRUE(!result.insert || IsUsable(result.match.verdict));
    }
    if (!orchard.IsSpoilt(i)) tracker.Insert(KeyframeId{static_cast<int>(i)}, scan, orchard.TruePose(i));
  }
  ASSERT_GT(num_spoilt, 25);
  ASSERT_GT(num_clean, 25);
  EXPECT_EQ(num_spoilt_inserted, 0);
  EXPECT_GE(num_clean_inserted, static_cast<int>(0.95 * num_clean));
}

TEST(TrackerTest, TheWideSearchFindsAPoseAfterAHeadlandTurn) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  TrackerOptions near_only;
  near_only.wide_translation = near_only.near_translation;
  near_only.wide_rotation = near_only.near_rotation;
  Tracker wide = MakeTracker(TrackerOptions());
  Tracker near = MakeTracker(near_only);
  ASSERT_EQ(near_only.Validate(), "");
  Build(orchard, 40, 25, &wide);
  Build(orchard, 40, 25, &near);
  for (const double turn : {2.0, -2.0}) {
    SCOPED_TRACE(turn);
    // The robot has turned by two radians since the last scan; nothing told of it.
    const SE2 truth = orchard.TruePose(64);
    const SE2 prediction = truth * SE2(0.3, 0.2, turn);
    const std::vector<Eigen::Vector2f> points = Project(orchard, 65).points;
    const SE2 seen_from = orchard.TruePose(65);
    const TrackingResult found = wide.Track(points, prediction, prediction);
    EXPECT_TRUE(found.searched_wide);
    ASSERT_TRUE(IsUsable(found.match.verdict));
    EXPECT_LT((found.match.pose.translation() - seen_from.translation()).norm(), 0.1);
    EXPECT_LT(std::abs(AngleDifference(found.match.pose.theta(), seen_from.theta())), 0.02);
    const TrackingResult lost = near.Track(points, prediction, prediction);
    EXPECT_TRUE(!IsUsable(lost.match.verdict) ||
                std::abs(AngleDifference(lost.match.pose.theta(), seen_from.theta())) > 1.0);
    EXPECT_FALSE(lost.insert);
  }
}

TEST(TrackerTest, TheWideSearchIsAroundTheLastPose) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  Tracker tracker = MakeTracker(TrackerOptions());
  Build(orchard, 40, 25, &tracker);
  const SE2 truth = orchard.TruePose(65);
  // The prediction has run away, farther than the wide search reaches; the last pose is right.
  const TrackingResult found =
      tracker.Track(Project(orchard, 65).points, orchard.TruePose(64), truth * SE2(3.0, 0.8, 0.7));
  EXPECT_TRUE(found.searched_wide);
  ASSERT_TRUE(IsUsable(found.match.verdict));
  EXPECT_LT((found.match.pose.translation() - truth.translation()).norm(), 0.1);
}

TEST(TrackerTest, ALostTrackerLooksFartherWithEveryScan) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  Tracker tracker = MakeTracker(TrackerOptions());
  Build(orchard, 40, 25, &tracker);
  const SE2 truth = orchard.TruePose(65);
  const std::vector<Eigen::Vector2f> points = Project(orchard, 65).points;
  // Two metres off and turned: outside the first wide search, within the third.
  const SE2 wrong = truth * SE2(0.4, 2.2, 0.8);
  int num_tries = 0;
  TrackingResult result;
  do {
    result = tracker.Track(points, wrong, wrong);
    ++num_tries;
  } while (!IsUsable(result.match.verdict) && num_tries < 5);
  ASSERT_TRUE(IsUsable(result.match.verdict));
  EXPECT_GT(num_tries, 1);
  EXPECT_LT((result.match.pose.translation() - truth.translation()).norm(), 0.1);
}

// Behind a corner nothing is known yet. Wheels tell where that is; without them a scan that fits nowhere is spoilt.
TEST(TrackerTest, NewGroundIsMappedWhereTheWheelsAre) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  const SE2 prediction = orchard.TruePose(65);
  std::vector<Eigen::Vector2f> wall;
  for (int i = 0; i < 80; ++i)
    wall.emplace_back(-3.0f - 0.5f * static_cast<float>(i % 2), 40.0f + 0.1f * static_cast<float>(i));
  for (const bool by_wheels : {true, false}) {
    Tracker tracker = MakeTracker(TrackerOptions());
    Build(orchard, 40, 25, &tracker);
    const TrackingResult result =
        tracker.Track(wall, orchard.TruePose(64), prediction, true, Eigen::Vector3d(0.02, 0.02, 0.01), by_wheels);
    EXPECT_FALSE(IsUsable(result.match.verdict));
    EXPECT_TRUE(result.match.pose.IsApprox(prediction));
    EXPECT_TRUE(result.measurements.empty());
    EXPECT_EQ(result.insert, by_wheels);
  }
}

TEST(TrackerTest, ByTheWheelsNoOtherPlaceIsSearched) {
  const PlanarOrchard orchard(WithSeed(3, 0.0));
  Tracker tracker = MakeTracker(TrackerOptions());
  Build(orchard, 40, 25, &tracker);
  // The truth lies outside of what wheels may err by.
  const SE2 truth = orchard.TruePose(65);
  const SE2 prediction = truth * SE2(0.3, 1.2, 0.9);
  const std::vector<Eigen::Vector2f> points = Project(orchard, 65).points;
  const Eigen::Vector3d sigma(0.02, 0.02, 0.01);
  const TrackingResult found = tracker.Track(points, prediction, prediction, true, sigma, true);
  EXPECT_TRUE(found.searched_wide);
  EXPECT_LT((found.match.pose.translation() - prediction.translation()).norm(), 0.75);
  EXPECT_LT(std::abs((prediction.Inverse() * found.match.pose).theta()), 0.25);
}

TEST(TrackerTest, ValidatesItsOptions) {
  EXPECT_EQ(TrackerOptions().Validate(), "");
  const auto rejects = [](auto change, const char* key) {
    TrackerOptions options;
    change(&options);
    return options.Validate().find(key) != std::string::npos;
  };
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->near_translation = 0.0; }, "near_translation"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->near_rotation = 4.0; }, "near_rotation"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->wide_translation = 0.1; }, "wide_translation"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->wide_rotation = 0.1; }, "wide_rotation"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->near_rotation_step = 0.0; }, "near_rotation_step"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->wide_rotation_step = 1.0; }, "wide_rotation_step"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->translation_penalty = -1.0; }, "translation_penalty"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->rotation_penalty = -1.0; }, "rotation_penalty"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->wide_score = 0.0; }, "wide_score"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->max_insert_score = -1.0; }, "max_insert_score"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->submap_length = 0.0; }, "submap_length"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->rebuild_distance = -0.1; }, "rebuild_distance"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->rebuild_turn = -0.1; }, "rebuild_turn"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->min_occupancy = 1.0; }, "min_occupancy"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->keyframe_translation = -1.0; }, "keyframe_translation"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->keyframe_rotation = -1.0; }, "keyframe_rotation"));
  EXPECT_TRUE(rejects([](TrackerOptions* o) { o->keyframe_interval = -1.0; }, "keyframe_interval"));
}

}  // namespace
}  // namespace arborslam
