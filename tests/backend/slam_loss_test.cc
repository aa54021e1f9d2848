// What a run does when tracking fails: maps that begin badly, robots that are carried away, scans that fit nothing.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "backend/run_verdict.h"
#include "backend/slam.h"
#include "core/geometry/angles.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

struct Outcome {
  FinishResult finish;
  RunVerdict verdict;
  Trajectory trajectory;
};

Outcome Process(const std::vector<LaserScan>& scans) {
  Slam slam(SlamOptions(), 2);
  for (const LaserScan& scan : scans) slam.AddScan(scan);
  Outcome run;
  run.finish = slam.Finish(false);
  run.trajectory = slam.OptimizedTrajectory();
  std::vector<size_t> indices(run.finish.pose_sources.size());
  std::iota(indices.begin(), indices.end(), size_t{0});
  run.verdict = JudgeRun(run.finish.pose_sources, run.finish.segments, indices);
  return run;
}

PlanarOrchardOptions Orchard(int seed, int num_scans) {
  PlanarOrchardOptions options;
  options.seed = seed;
  options.spoilt_scans = 0.0;
  options.num_scans = num_scans;
  return options;
}

size_t NumMeasured(const Outcome& run) {
  return static_cast<size_t>(
      std::count(run.finish.pose_sources.begin(), run.finish.pose_sources.end(), PoseSource::kMeasured));
}

TEST(SlamLoss, AMapThatBeganWithHalfAScanIsBegunAgain) {
  constexpr size_t kScans = 60;
  for (int seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    const PlanarOrchard orchard(Orchard(seed, kScans));
    std::vector<LaserScan> scans;
    for (size_t i = 0; i < kScans; ++i) scans.push_back(orchard.Scan(i));
    Random random(static_cast<uint64_t>(seed));
    const auto count = static_cast<double>(scans[0].ranges.size());
    const auto first = static_cast<std::ptrdiff_t>(random.Uniform(0.0, 0.3) * count);
    const auto last = first + static_cast<std::ptrdiff_t>(random.Uniform(0.3, 0.7) * count);
    std::fill(scans[0].ranges.begin() + first, scans[0].ranges.begin() + last, std::numeric_limits<float>::infinity());
    const Outcome run = Process(scans);
    EXPECT_GE(NumMeasured(run), kScans - 1);
    EXPECT_EQ(run.verdict.state, RunState::kOk) << TextOf(run.verdict);
    // A first scan of which too little is left is skipped.
    const size_t num_skipped = kScans - run.trajectory.size();
    ASSERT_LE(num_skipped, 1u);
    for (size_t i = 2; i < kScans; ++i) {
      const double truth = (orchard.TruePose(1).translation() - orchard.TruePose(i).translation()).norm();
      const SE2& first_pose = run.trajectory[1 - num_skipped].pose;
      EXPECT_NEAR((first_pose.translation() - run.trajectory[i - num_skipped].pose.translation()).norm(), truth, 0.3)
          << i;
    }
  }
}

// Twice around an orchard; after `last` scans of the first round the robot is carried to scan `next` of the second, and
// turned by `shift` beams.
std::vector<LaserScan> CarriedAway(const PlanarOrchard& orchard, size_t last, size_t next, size_t shift) {
  std::vector<LaserScan> scans;
  for (size_t i = 0; i < last; ++i) scans.push_back(orchard.Scan(i));
  for (size_t i = next; i < orchard.NumScans(); ++i) {
    LaserScan scan = orchard.Scan(i);
    std::rotate(scan.ranges.begin(), scan.ranges.begin() + static_cast<std::ptrdiff_t>(shift), scan.ranges.end());
    scans.push_back(std::move(scan));
  }
  return scans;
}

TEST(SlamLoss, ARobotThatIsCarriedAwayBeginsANewSegmentAndIsNeverJoinedWrongly) {
  size_t num_joined = 0;
  for (int seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE(seed);
    const PlanarOrchard once(Orchard(seed, 0));
    const size_t round = once.NumScans();
    const PlanarOrchard orchard(Orchard(seed, static_cast<int>(2 * round)));
    const size_t last = round - 20 * static_cast<size_t>(seed);
    const size_t next = last + 60;
    const double moved = (orchard.TruePose(last).translation() - orchard.TruePose(next).translation()).norm();
    ASSERT_GT(moved, 4.0);
    const Outcome run = Process(CarriedAway(orchard, last, next, 100 * static_cast<size_t>(seed)));
    EXPECT_EQ(run.verdict.state, RunState::kDegraded) << TextOf(run.verdict);
    ASSERT_GE(run.finish.segments.size(), 2u);
    const std::vector<bool> placed = PlacedScans(run.finish.pose_sources, run.finish.segments);
    if (std::all_of(run.finish.segments.begin(), run.finish.segments.end(),
                    [](const MapSegment& segment) { return segment.is_joined; })) {
      ++num_joined;
    }
    // Whatever is placed is placed in one frame: that of the first scan that is.
    const auto index_of = [&](size_t i) { return i < last ? i : i - last + next; };
    size_t anchor = 0;
    while (!placed[anchor]) ++anchor;
    for (size_t i = anchor; i < placed.size(); ++i) {
      if (!placed[i]) continue;
      const double truth =
          (orchard.TruePose(index_of(i)).translation() - orchard.TruePose(index_of(anchor)).translation()).norm();
      const double found = (run.trajectory[i].pose.translation() - run.trajectory[anchor].pose.translation()).norm();
      EXPECT_NEAR(found, truth, 0.5) << i;
    }
  }
  EXPECT_GE(num_joined, 1u);
}

TEST(SlamLoss, ScansThatFitNothingAreALostRun) {
  Random random(1);
  LaserScan scan = PlanarOrchard(Orchard(1, 1)).Scan(0);
  std::vector<LaserScan> scans;
  for (int i = 0; i < 15; ++i) {
    scan.stamp = i;
    for (float& range : scan.ranges) range = static_cast<float>(random.Uniform(1.0, 15.0));
    scans.push_back(scan);
  }
  EXPECT_EQ(Process(scans).verdict.state, RunState::kLost);
}

TEST(SlamLoss, ScansInBetweenAreInterpolated) {
  constexpr size_t kScans = 40;
  const PlanarOrchard orchard(Orchard(2, kScans));
  std::vector<LaserScan> scans;
  for (size_t i = 0; i < kScans; ++i) scans.push_back(orchard.Scan(i));
  for (size_t i = 20; i < 23; ++i) {
    std::fill(scans[i].ranges.begin(), scans[i].ranges.end(), std::numeric_limits<float>::infinity());
  }
  const Outcome run = Process(scans);
  for (size_t i = 20; i < 23; ++i) {
    EXPECT_EQ(run.finish.pose_sources[i], PoseSource::kInterpolated);
    const SE2 between =
        Interpolate(run.trajectory[19].pose, run.trajectory[23].pose, 0.25 * static_cast<double>(i - 19));
    EXPECT_LT((run.trajectory[i].pose.translation() - between.translation()).norm(), 1e-6);
  }
  EXPECT_EQ(run.finish.segments.size(), 1u);
}

}  // namespace
}  // namespace arborslam
