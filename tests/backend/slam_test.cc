#include "backend/slam.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/geometry/angles.h"
#include "core/simulation/planar_corridor.h"
#include "core/simulation/planar_lidar.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

struct Outcome {
  std::vector<ScanResult> scans;
  FinishResult finish;
  Trajectory trajectory;  // As optimised.
};

Outcome Process(const std::vector<LaserScan>& scans, int num_threads = 1, const SlamOptions& options = SlamOptions()) {
  Slam slam(options, num_threads);
  Outcome run;
  for (const LaserScan& scan : scans) run.scans.push_back(slam.AddScan(scan));
  run.finish = slam.Finish(false);
  run.trajectory = slam.OptimizedTrajectory();
  return run;
}

std::vector<LaserScan> ScansOf(const PlanarOrchard& orchard) {
  std::vector<LaserScan> scans;
  for (size_t i = 0; i < orchard.NumScans(); ++i) scans.push_back(orchard.Scan(i));
  return scans;
}

// Three rows of seven trees: a walk through both alleys that ends where it began. Nothing is random but where the trees
// stand.
PlanarOrchardOptions QuietOrchardOptions(int seed = 1) {
  PlanarOrchardOptions options = IdealPlanarOrchardOptions();
  options.seed = seed;
  options.rows = 3;
  options.trees_per_row = 7;
  options.position_jitter = 0.15;
  options.radius_spread = 0.03;
  options.missing_trees = 0.1;
  return options;
}

// The same with all that makes real recordings hard.
PlanarOrchardOptions NoisyOrchardOptions(int num_scans) {
  PlanarOrchardOptions options;
  options.seed = 5;
  options.rows = 3;
  options.trees_per_row = 7;
  options.num_scans = num_scans;
  return options;
}

// The pose of scan `index` seen from that of scan 0, where a run has its origin.
SE2 TruthOf(const PlanarOrchard& orchard, size_t index) {
  return orchard.TruePose(0).Inverse() * orchard.TruePose(index);
}

double Distance(const SE2& a, const SE2& b) { return (a.translation() - b.translation()).norm(); }
double Turn(const SE2& a, const SE2& b) { return std::abs(AngleDifference(a.theta(), b.theta())); }

void ExpectSamePose(const SE2& a, const SE2& b) {
  EXPECT_EQ(a.x(), b.x());
  EXPECT_EQ(a.y(), b.y());
  EXPECT_EQ(a.theta(), b.theta());
}

void ExpectSameResult(const ScanResult& a, const ScanResult& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.match.score, b.match.score);
  EXPECT_EQ(a.is_keyframe, b.is_keyframe);
  EXPECT_EQ(a.is_inserted, b.is_inserted);
  ExpectSamePose(a.T_odom_base, b.T_odom_base);
}

LaserScan EmptyLike(LaserScan scan) {
  std::fill(scan.ranges.begin(), scan.ranges.end(), std::numeric_limits<float>::infinity());
  return scan;
}

TEST(SlamTest, ClosesTheLoopOfAnOrchard) {
  for (const int seed : {1, 2}) {
    SCOPED_TRACE(seed);
    PlanarOrchardOptions options;
    options.seed = seed;
    options.spoilt_scans = 0.0;
    const PlanarOrchard orchard(options);
    const Outcome run = Process(ScansOf(orchard));
    ASSERT_EQ(run.trajectory.size(), orchard.NumScans());
    for (size_t i = 0; i < orchard.NumScans(); ++i) {
      EXPECT_EQ(run.scans[i].status, ScanStatus::kMatched) << i << ": " << run.scans[i].reason;
      EXPECT_EQ(run.trajectory[i].stamp, orchard.Stamp(i));
      EXPECT_LT(Distance(run.trajectory[i].pose, TruthOf(orchard, i)), 0.5) << i;
      EXPECT_LT(Turn(run.trajectory[i].pose, TruthOf(orchard, i)), 0.06) << i;
      EXPECT_LT(Distance(run.scans[i].T_odom_base, TruthOf(orchard, i)), 1.0) << i;
    }
    const SE2 last = TruthOf(orchard, orchard.NumScans() - 1);
    // The walk ends where it began.
    EXPECT_LT(Distance(run.trajectory.back().pose, last), 0.05);
    EXPECT_TRUE(std::any_of(run.finish.loops.begin(), run.finish.loops.end(),
                            [](const LoopCandidate& loop) { return loop.accepted; }));
  }
}

// Bare trunks are seen from one side on the way up an alley and from the other on the way down the next, and only turns
// of 0.4 to 0.7 rad a scan lead from one to the other. The poses in between may therefore err by a trunk's diameter.
TEST(SlamTest, ClosesTheLoopOfAQuietOrchard) {
  for (const int seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    const PlanarOrchard orchard(QuietOrchardOptions(seed));
    const Outcome run = Process(ScansOf(orchard));
    ASSERT_EQ(run.trajectory.size(), orchard.NumScans());
    for (size_t i = 0; i < orchard.NumScans(); ++i) {
      EXPECT_EQ(run.scans[i].status, ScanStatus::kMatched) << i << ": " << run.scans[i].reason;
      EXPECT_EQ(run.trajectory[i].stamp, orchard.Stamp(i));
      EXPECT_LT(Distance(run.trajectory[i].pose, TruthOf(orchard, i)), 0.2) << i;
      EXPECT_LT(Turn(run.trajectory[i].pose, TruthOf(orchard, i)), 0.02) << i;
      EXPECT_LT(Distance(run.scans[i].T_odom_base, TruthOf(orchard, i)), 0.2) << i;
    }
    // The walk ends where it began.
    EXPECT_LT(Distance(run.trajectory.back().pose, SE2()), 0.01);
    EXPECT_TRUE(std::any_of(run.finish.loops.begin(), run.finish.loops.end(),
                            [](const LoopCandidate& loop) { return loop.accepted; }));
  }
}

TEST(SlamTest, WithoutLoopsTheTrajectoryIsTheWindowsOwn) {
  const PlanarOrchard orchard(QuietOrchardOptions());
  Slam slam(SlamOptions(), 1);
  for (const LaserScan& scan : ScansOf(orchard)) slam.AddScan(scan);
  const Trajectory before = slam.OptimizedTrajectory();
  const FinishResult finish = slam.Finish(true);
  EXPECT_TRUE(finish.loops.empty());
  EXPECT_TRUE(finish.refinements.empty());
  EXPECT_FALSE(slam.submaps().empty());
  const Trajectory after = slam.OptimizedTrajectory();
  ASSERT_EQ(after.size(), orchard.NumScans());
  ASSERT_EQ(before.size(), orchard.NumScans());
  for (size_t i = 0; i < after.size(); ++i) ExpectSamePose(after[i].pose, before[i].pose);
}

TEST(SlamTest, NoiseLeavesAFewCentimetres) {
  PlanarOrchardOptions options;
  options.num_scans = 150;
  const PlanarOrchard orchard(options);
  const Outcome run = Process(ScansOf(orchard));
  const AssociationResult pairs = Associate(ToTrajectory3(run.trajectory), ToTrajectory3(orchard.GroundTruth()),
                                            AssociationOptions(), "the simulation");
  ASSERT_EQ(pairs.pairs.size(), orchard.NumScans());
  const TrajectoryMetrics metrics = EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2).metrics;
  EXPECT_LT(metrics.ate_rmse, 0.07);
  EXPECT_LT(*metrics.heading_rms, 0.02);
}

TEST(SlamTest, EqualToTheBitForAnyNumberOfThreads) {
  const PlanarOrchard orchard(NoisyOrchardOptions(0));
  const std::vector<LaserScan> scans = ScansOf(orchard);
  const Outcome one = Process(scans, 1);
  ASSERT_FALSE(one.finish.loops.empty());
  for (const int num_threads : {1, 2, 4}) {
    SCOPED_TRACE(num_threads);
    const Outcome other = Process(scans, num_threads);
    ASSERT_EQ(other.scans.size(), one.scans.size());
    for (size_t i = 0; i < one.scans.size(); ++i) ExpectSameResult(one.scans[i], other.scans[i]);
    ASSERT_EQ(other.trajectory.size(), one.trajectory.size());
    for (size_t i = 0; i < one.trajectory.size(); ++i) ExpectSamePose(one.trajectory[i].pose, other.trajectory[i].pose);
    ASSERT_EQ(other.finish.loops.size(), one.finish.loops.size());
    for (size_t i = 0; i < one.finish.loops.size(); ++i) {
      EXPECT_EQ(one.finish.loops[i].accepted, other.finish.loops[i].accepted);
      EXPECT_EQ(one.finish.loops[i].match.score, other.finish.loops[i].match.score);
    }
  }
}

TEST(SlamTest, OdometryDoesNotKnowTheFuture) {
  const PlanarOrchard orchard(NoisyOrchardOptions(60));
  const std::vector<LaserScan> scans = ScansOf(orchard);
  const Outcome whole = Process(scans);
  for (const size_t length : {1u, 2u, 17u, 40u}) {
    const Outcome part = Process({scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(length)});
    for (size_t i = 0; i < length; ++i) ExpectSameResult(part.scans[i], whole.scans[i]);
  }
}

TEST(SlamTest, ScansThatAreNotLaterAreSkipped) {
  const PlanarOrchard orchard(NoisyOrchardOptions(20));
  std::vector<LaserScan> scans = ScansOf(orchard);
  const Outcome clean = Process(scans);
  LaserScan same_time = orchard.Scan(15);
  same_time.stamp = scans[9].stamp;
  LaserScan earlier = orchard.Scan(18);
  earlier.stamp = scans[2].stamp;
  scans.insert(scans.begin() + 10, {same_time, earlier});
  const Outcome run = Process(scans);
  for (const size_t skipped : {10u, 11u}) {
    EXPECT_EQ(run.scans[skipped].status, ScanStatus::kSkipped);
    EXPECT_EQ(run.scans[skipped].reason, "stamp not after the scan before");
    EXPECT_FALSE(run.scans[skipped].is_keyframe);
    EXPECT_FALSE(run.scans[skipped].is_inserted);
  }
  // They leave no trace.
  ASSERT_EQ(run.trajectory.size(), clean.trajectory.size());
  for (size_t i = 0; i < clean.trajectory.size(); ++i) {
    EXPECT_EQ(run.trajectory[i].stamp, clean.trajectory[i].stamp);
    ExpectSamePose(run.trajectory[i].pose, clean.trajectory[i].pose);
  }
}

TEST(SlamTest, EmptyScansInTheMiddleArePredicted) {
  const PlanarOrchard orchard(QuietOrchardOptions());
  std::vector<LaserScan> scans = ScansOf(orchard);
  scans.resize(30);
  scans[12] = EmptyLike(scans[12]);
  std::fill(scans[20].ranges.begin(), scans[20].ranges.end(), std::numeric_limits<float>::quiet_NaN());
  const Outcome run = Process(scans);
  ASSERT_EQ(run.trajectory.size(), 30u);
  for (const size_t empty : {12u, 20u}) {
    EXPECT_EQ(run.scans[empty].status, ScanStatus::kPredicted);
    EXPECT_EQ(run.scans[empty].reason, "too few points");
    EXPECT_FALSE(run.scans[empty].is_inserted);
    const SE2& before = run.trajectory[empty - 1].pose;
    const SE2& after = run.trajectory[empty + 1].pose;
    const SE2& pose = run.trajectory[empty].pose;
    const Eigen::Vector2d way = after.translation() - before.translation();
    EXPECT_NEAR((pose.translation() - before.translation()).dot(way) / way.squaredNorm(), 0.5, 0.1);
    // The walk is straight here.
    EXPECT_LT(Distance(pose, TruthOf(orchard, empty)), 0.02);
    EXPECT_EQ(run.scans[empty + 1].status, ScanStatus::kMatched);
    EXPECT_LT(Distance(after, TruthOf(orchard, empty + 1)), 0.02);
  }
}

TEST(SlamTest, EmptyScansBeforeTheFirstMapAreSkipped) {
  const PlanarOrchard orchard(NoisyOrchardOptions(10));
  std::vector<LaserScan> scans = ScansOf(orchard);
  scans[0] = EmptyLike(scans[0]);
  scans[1].ranges.clear();
  const Outcome run = Process(scans);
  for (const size_t empty : {0u, 1u}) {
    EXPECT_EQ(run.scans[empty].status, ScanStatus::kSkipped);
    EXPECT_EQ(run.scans[empty].reason, "too few points");
  }
  ASSERT_EQ(run.trajectory.size(), 8u);
  EXPECT_EQ(run.trajectory.front().stamp, scans[2].stamp);
  EXPECT_LT(Distance(run.trajectory.front().pose, SE2()), 1e-9);
}

TEST(SlamTest, NoScanAndOneScan) {
  const Outcome none = Process({});
  EXPECT_TRUE(none.trajectory.empty());
  EXPECT_TRUE(none.finish.loops.empty());

  const PlanarOrchard orchard(NoisyOrchardOptions(1));
  const Outcome one = Process({orchard.Scan(0)}, 2);
  EXPECT_EQ(one.scans[0].status, ScanStatus::kMatched);
  EXPECT_TRUE(one.scans[0].is_inserted);
  ASSERT_EQ(one.trajectory.size(), 1u);
  EXPECT_LT(Distance(one.trajectory[0].pose, SE2()), 1e-9);
  EXPECT_LT(std::abs(one.trajectory[0].pose.theta()), 1e-9);
}

TEST(SlamTest, OnlyEmptyScans) {
  const PlanarOrchard orchard(NoisyOrchardOptions(3));
  std::vector<LaserScan> scans = ScansOf(orchard);
  for (LaserScan& scan : scans) scan = EmptyLike(scan);
  const Outcome run = Process(scans);
  EXPECT_TRUE(run.trajectory.empty());
  for (const ScanResult& scan : run.scans) EXPECT_EQ(scan.status, ScanStatus::kSkipped);
}

TEST(SlamTest, FindsItselfAfterATurnOfTwoRadiansBetweenTwoScans) {
  for (const double turn : {2.0, -2.0}) {
    SCOPED_TRACE(turn);
    const PlanarOrchard orchard(NoisyOrchardOptions(40));
    std::vector<LaserScan> scans = ScansOf(orchard);
    ASSERT_FALSE(orchard.IsSpoilt(25));
    // Turning the robot to the left turns what it sees to the right.
    for (size_t i = 25; i < scans.size(); ++i) scans[i].bearing_min -= turn;
    const Outcome run = Process(scans);
    EXPECT_TRUE(run.scans[25].searched_wide);
    for (size_t i = 0; i < scans.size(); ++i) {
      if (orchard.IsSpoilt(i)) continue;
      const SE2 truth = TruthOf(orchard, i) * SE2(0.0, 0.0, i < 25 ? 0.0 : turn);
      EXPECT_EQ(run.scans[i].status, ScanStatus::kMatched) << i;
      EXPECT_LT(Distance(run.scans[i].T_odom_base, truth), 0.2) << i;
      EXPECT_LT(Turn(run.scans[i].T_odom_base, truth), 0.06) << i;
    }
  }
}

TEST(SlamTest, EveryScanThatIsNotSkippedHasAPose) {
  const PlanarOrchard orchard(NoisyOrchardOptions(60));
  std::vector<LaserScan> scans = ScansOf(orchard);
  scans[0] = EmptyLike(scans[0]);
  for (const size_t i : {7u, 8u, 9u, 30u}) scans[i] = EmptyLike(scans[i]);
  scans[20].stamp = scans[19].stamp;
  // The robot stands: scans that are no keyframes.
  for (size_t i = 40; i < 46; ++i) scans[i].ranges = scans[39].ranges;
  const Outcome run = Process(scans);
  Trajectory expected;
  size_t num_not_keyframes = 0;
  for (const ScanResult& scan : run.scans) {
    if (scan.status == ScanStatus::kSkipped) continue;
    expected.push_back({scan.stamp, scan.T_odom_base});
    num_not_keyframes += scan.is_keyframe ? 0 : 1;
  }
  EXPECT_EQ(expected.size(), scans.size() - 2);
  EXPECT_GE(num_not_keyframes, 5u);
  ASSERT_EQ(run.trajectory.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(run.trajectory[i].stamp, expected[i].stamp);
    EXPECT_LT(Distance(run.trajectory[i].pose, expected[i].pose), 0.2) << i;
  }
}

// Nothing in the scans of a corridor tells how far along it the robot is, and a robot that has never been seen to move
// is taken to stand. Noise must not carry it away, and what the walls do tell must stay right.
TEST(SlamTest, ACorridorAloneInventsNoMotion) {
  PlanarCorridorOptions options;
  options.num_scans = 60;
  const PlanarCorridor corridor(options);
  std::vector<LaserScan> scans;
  for (size_t i = 0; i < corridor.NumScans(); ++i) scans.push_back(corridor.Scan(i));
  const Outcome run = Process(scans);
  ASSERT_EQ(run.trajectory.size(), scans.size());
  for (size_t i = 1; i < scans.size(); ++i) {
    EXPECT_EQ(run.scans[i].match.verdict, MatchVerdict::kDegenerate) << i;
    for (const SE2& pose : {run.scans[i].T_odom_base, run.trajectory[i].pose}) {
      EXPECT_LT(std::abs(pose.x()), 0.05) << i;
      EXPECT_LT(std::abs(pose.y()), 0.03) << i;
      EXPECT_LT(std::abs(pose.theta()), 0.02) << i;
    }
  }
}

// Trunks along the first metres show the robot's speed; farther on, where there are only walls, the motion model keeps
// it: each step along the corridor stays near the last one that was measured.
TEST(SlamTest, InACorridorTheSpeedGoesOn) {
  constexpr double kStep = 0.25;
  PlanarWorld world;
  world.walls.push_back({{-60.0, 1.5}, {60.0, 1.5}, 0.0});
  world.walls.push_back({{-60.0, -1.5}, {60.0, -1.5}, 0.0});
  for (int i = 0; i < 12; ++i) world.discs.push_back({{-6.0 + i, i % 2 == 0 ? 1.1 : -0.9}, 0.2});
  PlanarLidarOptions lidar_options;
  lidar_options.range_noise = 0.01;
  lidar_options.drop_out = 0.0;
  const PlanarLidar lidar(lidar_options);
  SlamOptions options;
  // The trunks are soon out of sight.
  options.projection.max_range = 6.0;
  Random random(3);
  std::vector<LaserScan> scans;
  for (int i = 0; i < 70; ++i) scans.push_back(lidar.Measure(world, SE2(kStep * i, 0.0, 0.0), i, Tilt(), &random));
  const Outcome run = Process(scans, 1, options);
  size_t num_degenerate = 0;
  for (size_t i = 10; i < scans.size(); ++i) {
    num_degenerate += run.scans[i].match.verdict == MatchVerdict::kDegenerate ? 1 : 0;
    const double step = run.scans[i].T_odom_base.x() - run.scans[i - 1].T_odom_base.x();
    EXPECT_NEAR(step, kStep, 0.05) << i;
    EXPECT_LT(std::abs(run.scans[i].T_odom_base.y()), 0.03) << i;
  }
  EXPECT_GE(num_degenerate, 20u);
}

// Wheels that run 3 % long and turn a little: what they say of the way along a corridor, where scans say nothing, is
// kept, and their turning is not.
TEST(SlamTest, InACorridorTheWheelsTellTheWay) {
  PlanarCorridorOptions options;
  options.num_scans = 60;
  const PlanarCorridor corridor(options);
  std::vector<LaserScan> scans;
  SE2 wheels(7.0, -4.0, 2.0);  // Their frame is their own.
  for (size_t i = 0; i < corridor.NumScans(); ++i) {
    scans.push_back(corridor.Scan(i));
    scans.back().odometry = wheels;
    wheels = wheels * SE2(1.03 * options.step, 0.0, 0.004);
  }
  const Outcome run = Process(scans);
  ASSERT_EQ(run.trajectory.size(), scans.size());
  for (size_t i = 1; i < scans.size(); ++i) {
    const double way = 1.03 * corridor.TruePose(i).x();
    for (const SE2& pose : {run.scans[i].T_odom_base, run.trajectory[i].pose}) {
      EXPECT_NEAR(pose.x(), way, 0.02 + 0.005 * way) << i;
      EXPECT_LT(std::abs(pose.y()), 0.04) << i;
      EXPECT_LT(std::abs(pose.theta()), 0.02) << i;
    }
  }
  // Switched off, there is no motion to be seen.
  SlamOptions without;
  without.odometry.enabled = false;
  EXPECT_LT(std::abs(Process(scans, 1, without).trajectory.back().pose.x()), 0.1);
}

// Where scans tell everything, wheels that run a tenth long and slip do little harm.
TEST(SlamTest, PoorWheelsDoNotSpoilAGoodMatch) {
  const PlanarOrchard orchard(QuietOrchardOptions());
  std::vector<LaserScan> scans = ScansOf(orchard);
  Random random(8);
  SE2 wheels;
  for (size_t i = 0; i < scans.size(); ++i) {
    if (i > 0) {
      const SE2 step = orchard.TruePose(i - 1).Inverse() * orchard.TruePose(i);
      wheels = wheels * step *
               SE2(0.1 * step.x() + 0.02 * random.Gaussian(), 0.02 * random.Gaussian(), 0.03 * random.Gaussian());
    }
    scans[i].odometry = wheels;
  }
  double greatest_wheel_error = 0.0;
  for (size_t i = 0; i < scans.size(); ++i) {
    const SE2 truth = orchard.TruePose(0).Inverse() * orchard.TruePose(i);
    greatest_wheel_error =
        std::max(greatest_wheel_error, (scans[i].odometry->translation() - truth.translation()).norm());
  }
  EXPECT_GT(greatest_wheel_error, 2.0);
  const auto greatest_error = [&](const SlamOptions& options) {
    const Outcome run = Process(scans, 1, options);
    EXPECT_EQ(run.trajectory.size(), scans.size());
    double greatest = 0.0;
    for (size_t i = 0; i < run.trajectory.size(); ++i) {
      const SE2 truth = orchard.TruePose(0).Inverse() * orchard.TruePose(i);
      greatest = std::max(greatest, (run.trajectory[i].pose.translation() - truth.translation()).norm());
    }
    return greatest;
  };
  SlamOptions without;
  without.odometry.enabled = false;
  EXPECT_LT(greatest_error(SlamOptions()), greatest_error(without) + 0.1);
}

}  // namespace
}  // namespace arborslam
