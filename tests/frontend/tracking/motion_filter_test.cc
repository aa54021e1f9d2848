#include "frontend/tracking/motion_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kStep = 0.1;  // [s]

Eigen::Matrix3d InformationOf(double translation, double rotation) {
  return MotionInformation({translation, translation, rotation});
}

// A robot that is told of step by step.
struct Drive {
  explicit Drive(const MotionOptions& options = MotionOptions()) : filter(options) {}

  // Goes on by `step`; its scan was matched off by `error`, and claims `information`. The filter is told the truth of
  // the scan before. Returns how far the prediction was off.
  Eigen::Vector3d Go(const SE2& step, const SE2& error, const Eigen::Matrix3d& information) {
    const StampedPose last{stamp, pose};
    stamp += kStep;
    pose = pose * step;
    const SE2 predicted = filter.Predict(last, stamp).pose;
    filter.Add(last, {stamp, pose * error}, information);
    return (predicted.Inverse() * pose).vector();
  }

  Eigen::Vector3d SigmaAfter(double step) const { return filter.Predict({stamp, pose}, stamp + step).sigma; }

  MotionFilter filter;
  double stamp = 0.0;
  SE2 pose = SE2(3.0, -2.0, 0.7);
};

SE2 Noise(double translation, double rotation, Random* random) {
  const double x = translation * random->Gaussian();
  const double y = translation * random->Gaussian();
  return SE2(x, y, rotation * random->Gaussian());
}

const SE2 kCurve(0.1, 0.0, 0.03);

TEST(MotionFilterTest, KnowsNothingAtFirst) {
  MotionOptions options;
  options.translation_sigma = 0.7;
  options.rotation_sigma = 0.4;
  const Drive drive(options);
  const MotionFilter::Prediction prediction = drive.filter.Predict({0.0, drive.pose}, kStep);
  EXPECT_EQ(prediction.pose.vector(), drive.pose.vector());
  EXPECT_EQ(prediction.sigma, Eigen::Vector3d(0.7, 0.7, 0.4));
  EXPECT_EQ(prediction.step_sigma, Eigen::Vector3d(0.7, 0.7, 0.4));
  EXPECT_EQ(drive.filter.velocity().linear, Eigen::Vector2d::Zero());
}

TEST(MotionFilterTest, PredictsEveryModelsOwnMotion) {
  for (const std::string model : {"omnidirectional", "unicycle", "constant_velocity"}) {
    MotionOptions options;
    options.model = model;
    Drive drive(options);
    // Straight on in the odometry frame while turning, or along an arc.
    const auto step_from = [&](const SE2& pose) {
      if (model != "constant_velocity") return SE2(0.0, 0.0, 0.02) * SE2(0.1, 0.0, 0.02);
      const SE2 next(pose.x() + 0.08, pose.y() + 0.05, pose.theta() + 0.04);
      return pose.Inverse() * next;
    };
    for (int i = 0; i < 40; ++i) drive.Go(step_from(drive.pose), SE2(), InformationOf(1e-3, 1e-3));
    const Eigen::Vector3d error = drive.Go(step_from(drive.pose), SE2(), InformationOf(1e-3, 1e-3));
    EXPECT_LT(error.norm(), 1e-3) << model;
  }
}

TEST(MotionFilterTest, GoodMatchesTellTheVelocityAtOnce) {
  Drive drive;
  drive.Go(kCurve, SE2(), InformationOf(1e-3, 1e-3));
  EXPECT_NEAR(drive.filter.velocity().linear.x(), 1.0, 0.01);
  EXPECT_NEAR(drive.filter.velocity().angular, 0.3, 0.01);
  EXPECT_LT(drive.Go(kCurve, SE2(), InformationOf(1e-3, 1e-3)).norm(), 0.01);
}

TEST(MotionFilterTest, LearnsHowMuchStepsDiffer) {
  Random random(3);
  Drive cart;
  Drive trotting;
  for (int i = 0; i < 300; ++i) {
    cart.Go(kCurve, Noise(0.002, 0.001, &random), InformationOf(0.002, 0.001));
    trotting.Go(kCurve * Noise(0.05, 0.03, &random), Noise(0.002, 0.001, &random), InformationOf(0.002, 0.001));
  }
  const Eigen::Vector3d of_cart = cart.SigmaAfter(kStep);
  const Eigen::Vector3d of_trotting = trotting.SigmaAfter(kStep);
  EXPECT_LT(of_cart.head<2>().maxCoeff(), 0.035);
  for (int axis = 0; axis < 2; ++axis) {
    // Steps that differ by 0.05 from a mean differ by 0.07 from one another.
    EXPECT_GT(of_trotting[axis], 0.07) << axis;
    EXPECT_LT(of_trotting[axis], 0.3) << axis;
  }
  EXPECT_GT(of_trotting.z(), 0.04);
}

// At a headland where a cart meets leaves only, matches scatter by as much as they say.
TEST(MotionFilterTest, KeepsItsCourseAmongMatchesThatKnowLittle) {
  Random random(5);
  Drive drive;
  for (int i = 0; i < 100; ++i) drive.Go(kCurve, Noise(0.01, 0.003, &random), InformationOf(0.01, 0.003));
  double greatest = 0.0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d error = drive.Go(kCurve, Noise(0.1, 0.02, &random), InformationOf(0.1, 0.02));
    greatest = std::max(greatest, error.head<2>().norm());
  }
  // The difference of two such matches errs by 0.14 on the average.
  EXPECT_LT(greatest, 0.06);
}

// Along a wall of leaves matches claim to know little, but agree with one another.
TEST(MotionFilterTest, FollowsABrakingRobotByMatchesThatKnowMoreThanTheySay) {
  Random random(6);
  Drive drive;
  for (int i = 0; i < 100; ++i) drive.Go(SE2(0.09, 0.0, 0.0), Noise(0.01, 0.003, &random), InformationOf(0.1, 0.02));
  double speed = 0.09;
  double greatest = 0.0;
  while (speed > 0.0) {
    speed -= 0.006;
    const SE2 step(std::max(speed, 0.0), 0.0, 0.0);
    const Eigen::Vector3d error = drive.Go(step, Noise(0.01, 0.003, &random), InformationOf(0.1, 0.02));
    greatest = std::max(greatest, std::abs(error.x()));
  }
  EXPECT_LT(greatest, 0.04);
  // What it expects counts no more than such matches.
  EXPECT_GT(drive.SigmaAfter(kStep).x(), 0.04);
}

TEST(MotionFilterTest, DirectionsThatAreNotMeasuredKeepTheirCourse) {
  Random random(9);
  Drive drive;
  for (int i = 0; i < 50; ++i) drive.Go(SE2(0.1, 0.0, 0.0), SE2(), InformationOf(0.005, 0.002));
  const Eigen::Matrix3d across = Eigen::Vector3d(0.0, 4e4, 2e5).asDiagonal();
  for (int i = 0; i < 20; ++i) drive.Go(SE2(0.1, 0.0, 0.0), SE2(0.05 * random.Gaussian(), 0.0, 0.0), across);
  EXPECT_NEAR(drive.filter.velocity().linear.x(), 1.0, 0.1);
  for (int i = 0; i < 20; ++i) drive.Go(SE2(0.1, 0.0, 0.0), SE2(0.3, 0.2, 0.1), Eigen::Matrix3d::Zero());
  EXPECT_NEAR(drive.filter.velocity().linear.x(), 1.0, 0.1);
  EXPECT_NEAR(drive.filter.velocity().linear.y(), 0.0, 0.1);
}

// As on a street between parallel walls: the first step that is found is all that tells the speed.
TEST(MotionFilterTest, TheFirstStepTellsTheVelocityThoughItIsHardlyKnown) {
  Drive drive;
  const Eigen::Matrix3d across = Eigen::Vector3d(0.0, 4e4, 2e5).asDiagonal();
  drive.Go(SE2(0.75, 0.0, 0.0), SE2(), across);
  EXPECT_NEAR(drive.filter.velocity().linear.x(), 7.5, 0.1);
  for (int i = 0; i < 10; ++i) drive.Go(SE2(0.75, 0.0, 0.0), SE2(), across);
  EXPECT_NEAR(drive.filter.velocity().linear.x(), 7.5, 0.1);
}

TEST(MotionFilterTest, SigmaIsBoundedByInertiaAndTheOptions) {
  MotionOptions options;
  options.translation_sigma = 0.2;
  options.rotation_sigma = 0.1;
  Drive steady(options);
  for (int i = 0; i < 300; ++i) steady.Go(kCurve, SE2(), InformationOf(1e-4, 1e-4));
  EXPECT_GE(steady.SigmaAfter(kStep).x(), 0.02);
  EXPECT_GE(steady.SigmaAfter(kStep).z(), 0.01);
  EXPECT_GE(steady.SigmaAfter(2.0 * kStep).x(), 0.04);
  Random random(8);
  Drive wild(options);
  for (int i = 0; i < 100; ++i) wild.Go(Noise(1.0, 0.5, &random), SE2(), InformationOf(1e-3, 1e-3));
  EXPECT_EQ(wild.SigmaAfter(kStep), Eigen::Vector3d(0.2, 0.2, 0.1));
  options.learn_sigma = false;
  Drive given(options);
  for (int i = 0; i < 100; ++i) given.Go(kCurve, SE2(), InformationOf(1e-3, 1e-3));
  EXPECT_EQ(given.SigmaAfter(kStep), Eigen::Vector3d(0.2, 0.2, 0.1));
}

TEST(MotionFilterTest, AfterAGapARobotIsTakenToStand) {
  Drive drive;
  for (int i = 0; i < 50; ++i) drive.Go(kCurve, SE2(), InformationOf(1e-3, 1e-3));
  const StampedPose last{drive.stamp, drive.pose};
  const MotionFilter::Prediction prediction = drive.filter.Predict(last, drive.stamp + 10.0);
  EXPECT_EQ(prediction.pose.vector(), drive.pose.vector());
  EXPECT_EQ(prediction.sigma, MotionOptions().GreatestSigma());
  // And it goes on from what it did in the gap.
  const SE2 after = drive.pose * SE2(0.5, 0.0, 0.0);
  drive.filter.Add(last, {drive.stamp + 10.0, after}, InformationOf(1e-3, 1e-3));
  EXPECT_NEAR(drive.filter.velocity().linear.x(), 0.05, 0.01);
}

}  // namespace
}  // namespace arborslam
