#include "core/evaluation/trajectory_metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

StampedPose3 PoseAt(double stamp, double x, double y, double z, double yaw) {
  return {stamp, {x, y, z}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()))};
}

// A loop with a heading that leaves the direction of travel, as a legged robot's does.
std::vector<StampedPose3> Loop(int count) {
  std::vector<StampedPose3> poses;
  for (int i = 0; i < count; ++i) {
    const double t = 2.0 * kPi * i / count;
    poses.push_back(PoseAt(i, 20.0 * std::cos(t), 8.0 * std::sin(2.0 * t), 0.3 * std::sin(5.0 * t), 3.0 * t));
  }
  return poses;
}

std::vector<PosePair> Pairs(const std::vector<StampedPose3>& estimates, const std::vector<StampedPose3>& references) {
  std::vector<PosePair> pairs;
  for (size_t i = 0; i < estimates.size(); ++i) pairs.push_back({estimates[i], references[i]});
  return pairs;
}

// Four poses, worked out by hand below.
std::vector<PosePair> HandMadePairs() {
  return {{PoseAt(0, 0.0, 0.0, 0.0, 0.0), PoseAt(0, 0.0, 0.0, 5.0, 0.0)},
          {PoseAt(1, 1.3, 0.0, 0.0, 0.1), PoseAt(1, 1.0, 0.0, 6.0, 0.0)},
          {PoseAt(2, 1.3, 0.8, 0.0, 1.5), PoseAt(2, 1.0, 1.2, 7.0, 1.6)},
          {PoseAt(3, 1.0, 0.8, 0.0, 3.1), PoseAt(3, 1.0, 2.2, 8.0, -3.1)}};
}

// Two runs over one stretch, whose references lie 0.1 m ahead of it and 0.1 m behind.
std::vector<RunPairs> HandMadeRuns() {
  return {{{{PoseAt(0, -1.0, 0.0, 0.0, 0.0), PoseAt(0, -0.9, 0.0, 0.0, 0.0)},
            {PoseAt(1, 1.0, 0.0, 0.0, 0.0), PoseAt(1, 1.1, 0.0, 0.0, 0.0)}},
           true},
          {{{PoseAt(9, -1.0, 0.0, 0.0, 0.0), PoseAt(9, -1.1, 0.0, 0.0, 0.0)},
            {PoseAt(10, 1.0, 0.0, 0.0, 0.0), PoseAt(10, 0.9, 0.0, 0.0, 0.0)}},
           false}};
}

TEST(EvaluateTogetherTest, WhatRunsLieOffEachOtherIsAnError) {
  // Alone, either fits its reference; together the best is to stay in the middle.
  const std::vector<RunPairs> runs = HandMadeRuns();
  EXPECT_NEAR(EvaluateTrajectory(runs[0].pairs, true, AlignmentKind::kSe2).metrics.ate_rmse, 0.0, 1e-12);
  const JointEvaluation joint = EvaluateTogether(runs, AlignmentKind::kSe2);
  EXPECT_EQ(joint.num_pairs, 4u);
  EXPECT_NEAR(joint.ate_rmse, 0.1, 1e-12);
  EXPECT_NEAR(joint.ate_median, 0.1, 1e-12);
  EXPECT_NEAR(joint.ate_max, 0.1, 1e-12);
  ASSERT_EQ(joint.runs.size(), 2u);
  for (const TrajectoryEvaluation& run : joint.runs) {
    EXPECT_TRUE(run.T_reference_estimate.isApprox(Eigen::Isometry3d::Identity(), 1e-12));
    EXPECT_NEAR(run.metrics.position_rms, 0.1, 1e-12);
    EXPECT_NEAR(run.metrics.ate_rmse, 0.1, 1e-12);
    EXPECT_NEAR(*run.metrics.step_length_rms, 0.0, 1e-12);
  }
  EXPECT_TRUE(joint.runs[0].metrics.heading_rms.has_value());
  EXPECT_FALSE(joint.runs[1].metrics.heading_rms.has_value());
}

TEST(EvaluateTogetherTest, OriginIsTheFirstPoseOfTheFirstRun) {
  const JointEvaluation joint = EvaluateTogether(HandMadeRuns(), AlignmentKind::kOrigin);
  EXPECT_NEAR(joint.runs[0].metrics.position_rms, 0.0, 1e-12);
  EXPECT_NEAR(joint.runs[1].metrics.position_rms, 0.2, 1e-12);
  EXPECT_NEAR(joint.ate_rmse, 0.1, 1e-12);
}

TEST(EvaluateTogetherTest, OneRunIsAsByItself) {
  const TrajectoryEvaluation alone = EvaluateTrajectory(HandMadePairs(), true, AlignmentKind::kSe2);
  const JointEvaluation joint = EvaluateTogether({{HandMadePairs(), true}}, AlignmentKind::kSe2);
  EXPECT_EQ(joint.ate_rmse, alone.metrics.ate_rmse);
  EXPECT_EQ(joint.runs.front().metrics.position_rms, alone.metrics.position_rms);
  EXPECT_EQ(joint.runs.front().z_offset, alone.z_offset);
}

TEST(EvaluateTogetherTest, NeedsPairsOfEveryRun) {
  EXPECT_THROW(EvaluateTogether({}, AlignmentKind::kSe2), std::invalid_argument);
  EXPECT_THROW(EvaluateTogether({{HandMadePairs(), true}, {{}, true}}, AlignmentKind::kSe2), std::invalid_argument);
}

TEST(TrajectoryMetricsTest, HandComputedFigures) {
  const TrajectoryEvaluation evaluation = EvaluateTrajectory(HandMadePairs(), true, AlignmentKind::kNone);
  const TrajectoryMetrics& m = evaluation.metrics;
  // Position errors 0, 0.3, 0.5, 1.4; the altitude of the reference does not count.
  EXPECT_NEAR(m.position_mean, 2.2 / 4.0, 1e-12);
  EXPECT_NEAR(m.position_rms, std::sqrt((0.09 + 0.25 + 1.96) / 4.0), 1e-12);
  EXPECT_NEAR(m.end_error, 1.4, 1e-12);
  // Path 1 + 1.2 + 1.
  EXPECT_NEAR(evaluation.path_length(), 3.2, 1e-12);
  EXPECT_NEAR(*m.position_percent, 0.55 / 3.2 * 100.0, 1e-12);
  // Heading errors 0, 0.1, 0.1 and, across the cut at pi, 2 pi - 6.2.
  const double across = 2.0 * kPi - 6.2;
  EXPECT_NEAR(*m.heading_mean, (0.2 + across) / 4.0, 1e-12);
  EXPECT_NEAR(*m.heading_rms, std::sqrt((0.02 + across * across) / 4.0), 1e-12);
  // Steps: lengths 1.3, 0.8, 0.3 for 1, 1.2, 1; errors 0.3, -0.4, -0.7.
  EXPECT_NEAR(*m.step_length_mean, -0.8 / 3.0, 1e-12);
  EXPECT_NEAR(*m.step_length_rms, std::sqrt((0.09 + 0.16 + 0.49) / 3.0), 1e-12);
  // Rotations 0.1, 1.4, 1.6 for 0, 1.6, 2 pi - 4.7; errors 0.1, -0.2, 6.3 - 2 pi.
  const double last = 6.3 - 2.0 * kPi;
  EXPECT_NEAR(*m.step_rotation_mean, (-0.1 + last) / 3.0, 1e-12);
  EXPECT_NEAR(*m.step_rotation_rms, std::sqrt((0.01 + 0.04 + last * last) / 3.0), 1e-12);
  EXPECT_EQ(evaluation.position_errors.size(), 4u);
  EXPECT_EQ(evaluation.path.size(), 4u);
}

TEST(TrajectoryMetricsTest, SpatialAlignmentCountsAltitudePlanarOnesDoNot) {
  std::vector<StampedPose3> high = Loop(40);
  for (size_t i = 0; i < high.size(); ++i) high[i].position.z() += i % 2 == 0 ? 0.5 : -0.5;
  const std::vector<PosePair> pairs = Pairs(Loop(40), high);
  EXPECT_LT(EvaluateTrajectory(pairs, true, AlignmentKind::kSe2).metrics.position_rms, 1e-9);
  const TrajectoryMetrics spatial = EvaluateTrajectory(pairs, true, AlignmentKind::kSe3).metrics;
  EXPECT_NEAR(spatial.position_rms, 0.5, 0.01);
  EXPECT_LT(spatial.ate_rmse, 1e-9);
}

TEST(TrajectoryMetricsTest, AMovedCopyHasNoErrorAfterAlignment) {
  const std::vector<StampedPose3> references = Loop(60);
  const Eigen::Isometry3d planar =
      Eigen::Translation3d(100.0, -50.0, 0.0) * Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitZ());
  const Eigen::Isometry3d spatial = planar * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 0.0).normalized());
  std::vector<StampedPose3> in_plane;
  std::vector<StampedPose3> in_space;
  for (const StampedPose3& pose : references) {
    in_plane.push_back(Transform(planar, pose));
    in_space.push_back(Transform(spatial, pose));
  }
  for (const AlignmentKind kind : {AlignmentKind::kOrigin, AlignmentKind::kSe2, AlignmentKind::kSe3}) {
    const TrajectoryMetrics m =
        EvaluateTrajectory(Pairs(kind == AlignmentKind::kSe3 ? in_space : in_plane, references), true, kind).metrics;
    EXPECT_LT(m.position_rms, 1e-9) << ToString(kind);
    EXPECT_LT(*m.heading_rms, 1e-9) << ToString(kind);
    EXPECT_LT(*m.step_length_rms, 1e-9) << ToString(kind);
    EXPECT_LT(*m.step_rotation_rms, 1e-9) << ToString(kind);
    EXPECT_LT(m.end_error, 1e-9) << ToString(kind);
    if (kind != AlignmentKind::kSe3) {
      EXPECT_LT(m.ate_max, 1e-9) << ToString(kind);
    }
  }
  const TrajectoryMetrics unaligned =
      EvaluateTrajectory(Pairs(in_plane, references), true, AlignmentKind::kNone).metrics;
  EXPECT_GT(unaligned.position_rms, 90.0);
  EXPECT_NEAR(*unaligned.heading_mean, 2.1, 1e-9);
  EXPECT_LT(unaligned.ate_max, 1e-9);
}

TEST(TrajectoryMetricsTest, OneOutlierShowsInTheMaximumNotInTheMedian) {
  std::vector<StampedPose3> estimates = Loop(1001);
  estimates[500].position.x() += 10.0;
  const TrajectoryMetrics m = EvaluateTrajectory(Pairs(estimates, Loop(1001)), true, AlignmentKind::kSe2).metrics;
  EXPECT_NEAR(m.ate_max, 10.0, 0.05);
  EXPECT_LT(m.ate_median, 0.05);
  EXPECT_NEAR(m.ate_rmse, 10.0 / std::sqrt(1001.0), 0.01);
  EXPECT_EQ(m.ate_rmse, m.position_rms);
}

TEST(TrajectoryMetricsTest, MedianOfAnEvenCountIsTheMiddleOfTheMiddleTwo) {
  // Symmetric about both axes, so that the alignment stays the identity: errors 1, 1, 3, 3.
  const std::vector<PosePair> pairs = {{PoseAt(0, 11.0, 0.0, 0.0, 0.0), PoseAt(0, 10.0, 0.0, 0.0, 0.0)},
                                       {PoseAt(1, -11.0, 0.0, 0.0, 0.0), PoseAt(1, -10.0, 0.0, 0.0, 0.0)},
                                       {PoseAt(2, 0.0, 13.0, 0.0, 0.0), PoseAt(2, 0.0, 10.0, 0.0, 0.0)},
                                       {PoseAt(3, 0.0, -13.0, 0.0, 0.0), PoseAt(3, 0.0, -10.0, 0.0, 0.0)}};
  const TrajectoryMetrics m = EvaluateTrajectory(pairs, true, AlignmentKind::kSe2).metrics;
  EXPECT_NEAR(m.ate_median, 2.0, 1e-12);
  EXPECT_NEAR(m.ate_max, 3.0, 1e-12);
  EXPECT_NEAR(m.ate_rmse, std::sqrt(5.0), 1e-12);
}

TEST(TrajectoryMetricsTest, StepErrorsDoNotDependOnTheAlignment) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.2);
  std::vector<StampedPose3> estimates = Loop(50);
  for (StampedPose3& pose : estimates) {
    pose.position += Eigen::Vector3d(noise(random), noise(random), 0.0);
    pose.orientation = pose.orientation * Eigen::AngleAxisd(noise(random), Eigen::Vector3d::UnitZ());
  }
  const std::vector<PosePair> pairs = Pairs(estimates, Loop(50));
  const TrajectoryMetrics none = EvaluateTrajectory(pairs, true, AlignmentKind::kNone).metrics;
  for (const AlignmentKind kind : {AlignmentKind::kOrigin, AlignmentKind::kSe2}) {
    const TrajectoryMetrics m = EvaluateTrajectory(pairs, true, kind).metrics;
    EXPECT_NEAR(*m.step_length_mean, *none.step_length_mean, 1e-9);
    EXPECT_NEAR(*m.step_rotation_rms, *none.step_rotation_rms, 1e-9);
    EXPECT_NEAR(m.ate_rmse, none.ate_rmse, 1e-12);
    EXPECT_GE(m.position_rms, m.ate_rmse - 1e-12);
  }
}

Eigen::Quaterniond FromYawPitchRoll(double yaw, double pitch, double roll) {
  return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
}

// A loop of a body that leans and bounces.
std::vector<StampedPose3> LeaningLoop(int count) {
  std::vector<StampedPose3> poses = Loop(count);
  for (size_t i = 0; i < poses.size(); ++i) {
    const double t = static_cast<double>(i);
    poses[i].orientation = poses[i].orientation * FromYawPitchRoll(0.0, 0.1 * std::sin(t), 0.2 * std::cos(0.7 * t));
  }
  return poses;
}

TEST(TrajectoryMetricsTest, RollPitchAndHeightAreComparedInThePlane) {
  Random random(9);
  const auto uniform = [&random] { return random.Uniform(-0.3, 0.3); };
  std::vector<StampedPose3> references;
  std::vector<StampedPose3> estimates;
  std::vector<double> roll_errors;
  std::vector<double> pitch_errors;
  std::vector<double> height_errors;
  for (const StampedPose3& pose : Loop(50)) {
    const double yaw = Heading(pose.orientation);
    const double pitch = uniform();
    const double roll = uniform();
    roll_errors.push_back(0.1 * uniform());
    pitch_errors.push_back(0.1 * uniform());
    height_errors.push_back(uniform());
    references.push_back({pose.stamp, pose.position, FromYawPitchRoll(yaw, pitch, roll)});
    // Another yaw must not matter to roll and pitch.
    estimates.push_back({pose.stamp, pose.position + Eigen::Vector3d(0.0, 0.0, 3.0 + height_errors.back()),
                         FromYawPitchRoll(yaw + uniform(), pitch + pitch_errors.back(), roll + roll_errors.back())});
  }
  const auto rms = [](const std::vector<double>& values, double offset) {
    double sum = 0.0;
    for (const double value : values) sum += (value - offset) * (value - offset);
    return std::sqrt(sum / static_cast<double>(values.size()));
  };
  double mean_height_error = 0.0;
  for (const double error : height_errors) mean_height_error += error / 50.0;

  const Eigen::Isometry3d moved =
      Eigen::Translation3d(100.0, -50.0, 0.0) * Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitZ());
  std::vector<StampedPose3> moved_estimates;
  for (const StampedPose3& pose : estimates) moved_estimates.push_back(Transform(moved, pose));
  const std::vector<PosePair> pairs = Pairs(moved_estimates, references);

  const TrajectoryEvaluation se2 = EvaluateTrajectory(pairs, true, AlignmentKind::kSe2);
  EXPECT_NEAR(*se2.metrics.roll_rms, rms(roll_errors, 0.0), 1e-9);
  EXPECT_NEAR(*se2.metrics.pitch_rms, rms(pitch_errors, 0.0), 1e-9);
  EXPECT_NEAR(se2.z_offset, -3.0 - mean_height_error, 1e-9);
  EXPECT_NEAR(*se2.metrics.z_rms, rms(height_errors, mean_height_error), 1e-9);
  EXPECT_NEAR(*se2.metrics.position_3d_rms, *se2.metrics.z_rms, 1e-9);
  EXPECT_LT(se2.metrics.position_rms, 1e-9);

  const TrajectoryEvaluation origin = EvaluateTrajectory(pairs, true, AlignmentKind::kOrigin);
  EXPECT_NEAR(*origin.metrics.roll_rms, rms(roll_errors, 0.0), 1e-9);
  EXPECT_NEAR(*origin.metrics.z_rms, rms(height_errors, height_errors.front()), 1e-9);
  EXPECT_NEAR(std::pow(*origin.metrics.position_3d_rms, 2),
              std::pow(origin.metrics.position_rms, 2) + std::pow(*origin.metrics.z_rms, 2), 1e-9);

  const TrajectoryEvaluation none = EvaluateTrajectory(pairs, true, AlignmentKind::kNone);
  EXPECT_NEAR(*none.metrics.pitch_rms, rms(pitch_errors, 0.0), 1e-9);
  EXPECT_NEAR(*none.metrics.z_rms, rms(height_errors, -3.0), 1e-9);
  EXPECT_EQ(none.z_offset, 0.0);
}

TEST(TrajectoryMetricsTest, AnAlignmentInSpaceTurnsRollPitchAndHeightWithIt) {
  const std::vector<StampedPose3> references = LeaningLoop(60);
  const Eigen::Isometry3d spatial =
      Eigen::Translation3d(4.0, -5.0, 6.0) * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
  std::vector<StampedPose3> estimates;
  for (const StampedPose3& pose : references) estimates.push_back(Transform(spatial, pose));
  const TrajectoryMetrics se3 = EvaluateTrajectory(Pairs(estimates, references), true, AlignmentKind::kSe3).metrics;
  EXPECT_LT(*se3.roll_rms, 1e-9);
  EXPECT_LT(*se3.pitch_rms, 1e-9);
  EXPECT_LT(*se3.z_rms, 1e-9);
  EXPECT_LT(*se3.position_3d_rms, 1e-9);
  EXPECT_GT(*EvaluateTrajectory(Pairs(estimates, references), true, AlignmentKind::kSe2).metrics.roll_rms, 0.05);

  std::vector<StampedPose3> bumpy = references;
  for (size_t i = 0; i < bumpy.size(); ++i) bumpy[i].position.z() += i % 2 == 0 ? 0.5 : -0.5;
  const TrajectoryMetrics m = EvaluateTrajectory(Pairs(bumpy, references), true, AlignmentKind::kSe3).metrics;
  EXPECT_EQ(*m.position_3d_rms, m.position_rms);
  EXPECT_NEAR(*m.z_rms, 0.5, 0.01);
}

TEST(TrajectoryMetricsTest, RollBeyondThePlumbIsComparedTheShortWay) {
  StampedPose3 estimate = PoseAt(0, 0.0, 0.0, 1.0, 0.0);
  StampedPose3 reference = estimate;
  estimate.orientation = FromYawPitchRoll(0.4, 0.0, 3.1);
  reference.orientation = FromYawPitchRoll(-0.4, 0.0, -3.1);
  const TrajectoryMetrics m = EvaluateTrajectory({{estimate, reference}}, true, AlignmentKind::kNone).metrics;
  EXPECT_NEAR(*m.roll_rms, 2.0 * kPi - 6.2, 1e-9);
}

TEST(TrajectoryMetricsTest, APlanarTrajectoryHasNoRollPitchOrHeight) {
  const std::vector<StampedPose3> leaning = LeaningLoop(30);
  std::vector<StampedPose3> flat = Loop(30);
  for (StampedPose3& pose : flat) pose.position.z() = 0.0;
  std::vector<StampedPose3> leaning_at_no_height = leaning;
  for (StampedPose3& pose : leaning_at_no_height) pose.position.z() = 0.0;
  for (const AlignmentKind kind :
       {AlignmentKind::kNone, AlignmentKind::kOrigin, AlignmentKind::kSe2, AlignmentKind::kSe3}) {
    for (const std::vector<PosePair>& pairs : {Pairs(flat, leaning), Pairs(leaning, flat), Pairs(flat, flat)}) {
      const TrajectoryMetrics m = EvaluateTrajectory(pairs, true, kind).metrics;
      EXPECT_FALSE(m.roll_rms) << ToString(kind);
      EXPECT_FALSE(m.pitch_rms) << ToString(kind);
      EXPECT_FALSE(m.z_rms) << ToString(kind);
      EXPECT_FALSE(m.position_3d_rms) << ToString(kind);
    }
    // Heights without attitudes and the reverse.
    const TrajectoryMetrics heights = EvaluateTrajectory(Pairs(Loop(30), leaning), true, kind).metrics;
    EXPECT_FALSE(heights.roll_rms) << ToString(kind);
    EXPECT_TRUE(heights.z_rms) << ToString(kind);
    const TrajectoryMetrics attitudes = EvaluateTrajectory(Pairs(leaning_at_no_height, leaning), true, kind).metrics;
    EXPECT_TRUE(attitudes.pitch_rms) << ToString(kind);
    EXPECT_FALSE(attitudes.position_3d_rms) << ToString(kind);
    EXPECT_FALSE(EvaluateTrajectory(Pairs(leaning, leaning), false, kind).metrics.roll_rms) << ToString(kind);
  }
}

TEST(TrajectoryMetricsTest, WithoutHeadingsTheirFiguresAreAbsent) {
  const TrajectoryMetrics m = EvaluateTrajectory(HandMadePairs(), false, AlignmentKind::kSe2).metrics;
  EXPECT_FALSE(m.heading_mean);
  EXPECT_FALSE(m.heading_rms);
  EXPECT_FALSE(m.step_rotation_mean);
  EXPECT_FALSE(m.step_rotation_rms);
  EXPECT_TRUE(m.step_length_mean);
}

TEST(TrajectoryMetricsTest, OnePoseHasNoSteps) {
  const std::vector<PosePair> one = {HandMadePairs()[2]};
  const TrajectoryEvaluation evaluation = EvaluateTrajectory(one, true, AlignmentKind::kNone);
  EXPECT_NEAR(evaluation.metrics.position_mean, 0.5, 1e-12);
  EXPECT_NEAR(*evaluation.metrics.heading_mean, 0.1, 1e-12);
  EXPECT_FALSE(evaluation.metrics.step_length_mean);
  EXPECT_FALSE(evaluation.metrics.step_rotation_mean);
  EXPECT_FALSE(evaluation.metrics.position_percent);
  EXPECT_EQ(evaluation.path_length(), 0.0);
  EXPECT_NEAR(evaluation.metrics.ate_rmse, 0.0, 1e-12);
  EXPECT_THROW(EvaluateTrajectory({}, true, AlignmentKind::kSe2), std::invalid_argument);
}

TEST(TrajectoryMetricsTest, AReferenceThatStandsStillHasNoPercentage) {
  std::vector<PosePair> pairs = HandMadePairs();
  for (PosePair& pair : pairs) pair.reference = pairs[0].reference;
  const TrajectoryMetrics m = EvaluateTrajectory(pairs, true, AlignmentKind::kSe2).metrics;
  EXPECT_FALSE(m.position_percent);
  EXPECT_TRUE(std::isfinite(m.ate_rmse));
}

TEST(TrajectoryMetricsTest, FieldsCoverEveryFigureOnce) {
  TrajectoryMetrics m;
  m.position_mean = 1.0;
  m.position_rms = 2.0;
  m.heading_mean = 3.0;
  m.heading_rms = 4.0;
  m.step_length_mean = 5.0;
  m.step_length_rms = 6.0;
  m.step_rotation_mean = 7.0;
  m.step_rotation_rms = 8.0;
  m.position_percent = 9.0;
  m.end_error = 10.0;
  m.roll_rms = 11.0;
  m.pitch_rms = 12.0;
  m.z_rms = 13.0;
  m.position_3d_rms = 14.0;
  m.ate_rmse = 15.0;
  m.ate_median = 16.0;
  m.ate_max = 17.0;
  std::set<std::string> keys;
  double expected = 1.0;
  for (const MetricField& field : MetricFields()) {
    EXPECT_EQ(field.value(m), expected) << field.key;
    expected += 1.0;
    keys.insert(field.key);
  }
  EXPECT_EQ(keys.size(), 17u);
}

TEST(RunSummaryTest, MeanAndHalfWidth) {
  // sd of 1, 2, 3, 6 with N - 1 is sqrt(14 / 3).
  const std::optional<RunSummary> summary = SummarizeRuns({1.0, 2.0, 3.0, 6.0});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->num_runs, 4u);
  EXPECT_NEAR(summary->mean, 3.0, 1e-12);
  EXPECT_NEAR(*summary->half_width, 1.96 * std::sqrt(14.0 / 3.0) / 2.0, 1e-12);
}

TEST(RunSummaryTest, OneRunHasNoHalfWidthAndNoneNoSummary) {
  EXPECT_FALSE(SummarizeRuns({}));
  const std::optional<RunSummary> summary = SummarizeRuns({4.0});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->mean, 4.0);
  EXPECT_FALSE(summary->half_width);
}

}  // namespace
}  // namespace arborslam
