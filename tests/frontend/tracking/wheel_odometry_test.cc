#include "frontend/tracking/wheel_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "core/io/binary_archive.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

const Eigen::Matrix3d kSure = 1e8 * Eigen::Matrix3d::Identity();

TEST(WheelOdometryTest, GivesTheMotionInTheLidarsFrame) {
  WheelOdometry wheels((OdometryOptions()));
  EXPECT_FALSE(wheels.has_odometry());
  EXPECT_FALSE(wheels.SinceScan(SE2(1.0, 2.0, 0.3)).has_value());
  const SE2 first(5.0, -3.0, 2.0);
  const SE2 motion(0.4, 0.1, -0.2);
  wheels.Commit(first, true);
  EXPECT_TRUE(wheels.has_odometry());
  ASSERT_TRUE(wheels.SinceScan(first * motion).has_value());
  EXPECT_TRUE(wheels.SinceScan(first * motion)->motion.IsApprox(motion));
  // A scan that is no keyframe lies between: steps from the keyframe go on.
  wheels.Commit(first * motion, false);
  EXPECT_TRUE(wheels.SinceScan(first * motion * motion)->motion.IsApprox(motion));
  EXPECT_TRUE(wheels.SinceKeyframe(first * motion * motion)->motion.IsApprox(motion * motion));
}

TEST(WheelOdometryTest, WithoutOdometryOnEitherSideThereIsNoStep) {
  WheelOdometry wheels((OdometryOptions()));
  wheels.Commit(SE2(), true);
  EXPECT_FALSE(wheels.SinceScan(std::nullopt).has_value());
  wheels.Commit(std::nullopt, false);
  EXPECT_FALSE(wheels.SinceScan(SE2()).has_value());
  EXPECT_TRUE(wheels.SinceKeyframe(SE2()).has_value());
  wheels.Commit(std::nullopt, true);
  EXPECT_FALSE(wheels.SinceKeyframe(SE2()).has_value());
}

TEST(WheelOdometryTest, IsNotUsedWhenSwitchedOff) {
  OdometryOptions options;
  options.enabled = false;
  WheelOdometry wheels(options);
  wheels.Commit(SE2(), true);
  EXPECT_FALSE(wheels.SinceScan(SE2()).has_value());
}

TEST(WheelOdometryTest, SigmaGrowsWithWayAndTurn) {
  OdometryOptions options;
  options.translation_sigma = 0.03;
  options.translation_per_metre = 0.1;
  options.translation_per_turn = 0.2;
  options.rotation_sigma = 0.01;
  options.rotation_per_metre = 0.02;
  options.rotation_per_turn = 0.05;
  WheelOdometry wheels(options);
  wheels.Commit(SE2(), true);
  EXPECT_TRUE(wheels.SinceScan(SE2())->sigma.isApprox(Eigen::Vector3d(0.03, 0.03, 0.01)));
  const Eigen::Vector3d sigma = wheels.SinceScan(SE2(3.0, 4.0, -1.0))->sigma;
  EXPECT_NEAR(sigma.x(), std::sqrt(0.03 * 0.03 + 0.5 * 0.5 + 0.2 * 0.2), 1e-12);
  EXPECT_EQ(sigma.x(), sigma.y());
  EXPECT_NEAR(sigma.z(), std::sqrt(0.01 * 0.01 + 0.1 * 0.1 + 0.05 * 0.05), 1e-12);
}

// Wheels that err by `share` of what the options say, per axis.
Eigen::Vector3d LearnedSigma(const Eigen::Vector3d& share, const Eigen::Matrix3d& information, bool learn = true) {
  OdometryOptions options;
  options.learn_sigma = learn;
  WheelOdometry wheels(options);
  Random random(4);
  SE2 pose;
  wheels.Commit(pose, true);
  const SE2 motion(0.2, 0.0, 0.1);
  for (int i = 0; i < 150; ++i) {
    pose = pose * motion;
    const OdometryStep step = *wheels.SinceScan(pose);
    WheelOdometry fresh(options);
    fresh.Commit(SE2(), true);
    const Eigen::Vector3d noise = fresh.SinceScan(motion)->sigma.cwiseProduct(share);
    const SE2 error(noise.x() * random.Gaussian(), noise.y() * random.Gaussian(), noise.z() * random.Gaussian());
    wheels.Learn(step, step.motion * error, information);
    wheels.Commit(pose, true);
  }
  WheelOdometry fresh(options);
  fresh.Commit(SE2(), true);
  return wheels.SinceScan(pose * motion)->sigma.cwiseQuotient(fresh.SinceScan(motion)->sigma);
}

TEST(WheelOdometryTest, LearnsHowFarTheWheelsErrOnEveryAxis) {
  const Eigen::Vector3d share(3.0, 0.5, 1.0);
  const Eigen::Vector3d learned = LearnedSigma(share, kSure);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(learned[axis], 1.1 * share[axis]) << axis;  // On the safe side,
    EXPECT_LT(learned[axis], 2.2 * share[axis]) << axis;  // but not by much.
  }
}

TEST(WheelOdometryTest, LearnsNothingFromMatchesThatKnowLess) {
  Eigen::Matrix3d along_unknown = kSure;
  along_unknown(0, 0) = 0.0;
  const Eigen::Vector3d learned = LearnedSigma({5.0, 5.0, 5.0}, along_unknown);
  EXPECT_DOUBLE_EQ(learned.x(), 1.0);
  EXPECT_GT(learned.y(), 5.0);
  EXPECT_TRUE(LearnedSigma({5.0, 5.0, 5.0}, kSure, false).isApprox(Eigen::Vector3d::Ones()));
}

TEST(WheelOdometryTest, StateComesBackToTheBit) {
  WheelOdometry wheels((OdometryOptions()));
  Random random(9);
  SE2 pose;
  for (int i = 0; i < 60; ++i) {
    const SE2 next = pose * SE2(0.1, 0.01 * random.Gaussian(), 0.02);
    if (const auto step = wheels.SinceScan(next)) wheels.Learn(*step, SE2(0.1, 0.0, 0.02), kSure);
    wheels.Commit(next, i % 3 == 0);
    pose = next;
  }
  BinaryWriter writer;
  writer(wheels);
  WheelOdometry read((OdometryOptions()));
  BinaryReader reader(writer.bytes(), "state");
  reader(read);
  reader.CheckEnd();
  const SE2 next = pose * SE2(0.3, 0.0, 0.1);
  EXPECT_EQ(read.SinceScan(next)->sigma, wheels.SinceScan(next)->sigma);
  EXPECT_EQ(read.SinceKeyframe(next)->motion.vector(), wheels.SinceKeyframe(next)->motion.vector());
}

TEST(WheelOdometryTest, OptionsOutOfRange) {
  EXPECT_EQ(OdometryOptions().Validate(), "");
  OdometryOptions options;
  options.translation_sigma = 0.0;
  EXPECT_EQ(options.Validate(), "translation_sigma is 0.0, must be above 0 m");
  options = OdometryOptions();
  options.rotation_per_turn = -0.1;
  EXPECT_NE(options.Validate().find("rotation_per_turn"), std::string::npos);
}

TEST(WheelOdometry, AJumpIsNoStep) {
  WheelOdometry wheels{OdometryOptions()};
  wheels.Commit(SE2(1.0, 2.0, 0.0), true);
  EXPECT_TRUE(wheels.SinceScan(SE2(3.0, 2.0, 0.0)).has_value());
  EXPECT_FALSE(wheels.SinceScan(SE2(3e7, 2.0, 0.0)).has_value());
  wheels.Commit(SE2(3e7, 2.0, 0.0), true);
  EXPECT_TRUE(wheels.SinceScan(SE2(3e7 + 1.0, 2.0, 0.0)).has_value());
}

}  // namespace
}  // namespace arborslam
