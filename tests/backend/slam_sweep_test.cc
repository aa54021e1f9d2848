// The whole method on sweeps in space.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "backend/slam.h"
#include "core/geometry/angles.h"
#include "core/simulation/orchard.h"
#include "core/simulation/simulated_run.h"

namespace arborslam {
namespace {

// The beginning of a walk through an orchard, 40 m or so at two sweeps a second.
std::vector<LidarSweep> Walk(size_t num_sweeps, Trajectory3* truth) {
  OrchardOptions options;
  options.run.seed = 5;
  const SimulatedRun run(options.run, MakeOrchard(options));
  std::vector<LidarSweep> sweeps;
  for (size_t i = 0; i < num_sweeps; ++i) {
    const size_t index = 2 * i;
    sweeps.push_back(run.Sweep(index));
    const Eigen::Isometry3d pose = run.TruePose(index);
    if (truth != nullptr) {
      truth->poses.push_back({run.Middle(index), pose.translation(), Eigen::Quaterniond(pose.linear())});
    }
  }
  return sweeps;
}

TEST(SlamSweepTest, FollowsAWalkInSpace) {
  Trajectory3 truth;
  const std::vector<LidarSweep> sweeps = Walk(120, &truth);
  Slam slam(SlamOptions(), 1);
  for (const LidarSweep& sweep : sweeps) {
    const ScanResult result = slam.AddScan(sweep);
    EXPECT_EQ(result.status, ScanStatus::kMatched) << result.reason;
    EXPECT_TRUE(result.has_ground);
    EXPECT_EQ(result.stamp, sweep.Middle());
  }
  slam.Finish(false);
  const Trajectory3 estimate = slam.OptimizedTrajectory3();
  ASSERT_EQ(estimate.poses.size(), truth.poses.size());
  // In the frame of the first pose, from above.
  const Trajectory planar = ToPlanar(estimate);
  const Trajectory planar_truth = ToPlanar(truth);
  const SE2 T_truth_estimate = planar_truth.front().pose * planar.front().pose.Inverse();
  const double z_offset = truth.poses.front().position.z() - estimate.poses.front().position.z();
  for (size_t i = 0; i < planar.size(); ++i) {
    EXPECT_EQ(estimate.poses[i].stamp, sweeps[i].Middle());
    const SE2 error = planar_truth[i].pose.Inverse() * T_truth_estimate * planar[i].pose;
    EXPECT_LT(error.translation().norm(), 0.25) << i;
    EXPECT_LT(std::abs(error.theta()), 0.03) << i;
    // Against gravity, but for what the slope of so short a stretch of ground leaves open.
    const Tilt3 tilt = TiltOf(estimate.poses[i].orientation.toRotationMatrix());
    const Tilt3 true_tilt = TiltOf(truth.poses[i].orientation.toRotationMatrix());
    EXPECT_NEAR(tilt.roll, true_tilt.roll, DegToRad(4.0)) << i;
    EXPECT_NEAR(tilt.pitch, true_tilt.pitch, DegToRad(4.0)) << i;
    EXPECT_NEAR(estimate.poses[i].position.z() + z_offset, truth.poses[i].position.z(), 1.5) << i;
  }
  // From one sweep to the next the trot tilts the lidar: this is known much better.
  double squared = 0.0;
  for (size_t i = 1; i < planar.size(); ++i) {
    const auto step = [i](const Trajectory3& trajectory) {
      return TiltOf(trajectory.poses[i].orientation.toRotationMatrix()).roll -
             TiltOf(trajectory.poses[i - 1].orientation.toRotationMatrix()).roll;
    };
    squared += std::pow(step(estimate) - step(truth), 2);
  }
  EXPECT_LT(std::sqrt(squared / static_cast<double>(planar.size() - 1)), DegToRad(0.5));
}

TEST(SlamSweepTest, IsTheSameForAnyNumberOfThreads) {
  const std::vector<LidarSweep> sweeps = Walk(40, nullptr);
  std::vector<Trajectory3> results;
  for (const int num_threads : {1, 2}) {
    Slam slam(SlamOptions(), num_threads);
    for (const LidarSweep& sweep : sweeps) slam.AddScan(sweep);
    slam.Finish(false);
    results.push_back(slam.OptimizedTrajectory3());
  }
  ASSERT_EQ(results[0].poses.size(), results[1].poses.size());
  for (size_t i = 0; i < results[0].poses.size(); ++i) {
    EXPECT_EQ(results[0].poses[i].position, results[1].poses[i].position);
    EXPECT_EQ(results[0].poses[i].orientation.coeffs(), results[1].poses[i].orientation.coeffs());
  }
}

TEST(SlamSweepTest, GetsOverEmptyAndLateSweeps) {
  std::vector<LidarSweep> sweeps = Walk(24, nullptr);
  LidarSweep empty = sweeps[10];
  empty.points.clear();
  empty.times.clear();
  LidarSweep first;
  first.start = sweeps.front().start - 10.0;
  Slam slam(SlamOptions(), 1);
  EXPECT_EQ(slam.AddScan(first).status, ScanStatus::kSkipped);
  for (size_t i = 0; i < sweeps.size(); ++i) {
    const ScanResult result = slam.AddScan(i == 10 ? empty : sweeps[i]);
    EXPECT_EQ(result.status, i == 10 ? ScanStatus::kPredicted : ScanStatus::kMatched) << i << " " << result.reason;
    EXPECT_EQ(result.has_ground, i != 10) << i;
  }
  const ScanResult late = slam.AddScan(sweeps[3]);
  EXPECT_EQ(late.status, ScanStatus::kSkipped);
  EXPECT_FALSE(late.reason.empty());
  slam.Finish(false);
  EXPECT_EQ(slam.OptimizedTrajectory3().poses.size(), sweeps.size());
}

}  // namespace
}  // namespace arborslam
