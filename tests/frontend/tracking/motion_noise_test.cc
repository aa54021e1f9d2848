#include "frontend/tracking/motion_noise.h"

#include <gtest/gtest.h>

#include <random>

namespace arborslam {
namespace {

const Eigen::Matrix3d kGoodMatch = 1e6 * Eigen::Matrix3d::Identity();
const SE2 kStep(0.1, 0.0, 0.02);

// Tells `noise` of `count` steps whose predictions err at random with `sigma`.
void AddRandomErrors(const Eigen::Vector3d& sigma, int count, const Eigen::Matrix3d& information, MotionNoise* noise) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  SE2 pose(3.0, -2.0, 0.7);
  for (int i = 0; i < count; ++i) {
    const SE2 prediction = pose * kStep;
    const SE2 error(sigma.x() * normal(random), sigma.y() * normal(random), sigma.z() * normal(random));
    const SE2 matched = prediction * error;
    noise->Add(pose, prediction, matched, information);
    pose = matched;
  }
}

TEST(MotionNoiseTest, KnowsNothingAtFirst) {
  MotionOptions options;
  options.translation_sigma = 0.7;
  options.rotation_sigma = 0.4;
  MotionNoise noise(options);
  EXPECT_TRUE(noise.sigma().isApprox(Eigen::Vector3d(0.7, 0.7, 0.4)));
  AddRandomErrors({0.05, 0.05, 0.05}, 10, kGoodMatch, &noise);
  EXPECT_TRUE(noise.sigma().isApprox(Eigen::Vector3d(0.7, 0.7, 0.4), 0.2));
}

TEST(MotionNoiseTest, LearnsHowFarPredictionsErrInEachDirection) {
  MotionNoise noise((MotionOptions()));
  const Eigen::Vector3d sigma(0.05, 0.1, 0.04);
  AddRandomErrors(sigma, 400, kGoodMatch, &noise);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(noise.sigma()[axis], 1.5 * sigma[axis]) << axis;
    EXPECT_LT(noise.sigma()[axis], 4.0 * sigma[axis]) << axis;
  }
}

TEST(MotionNoiseTest, NeitherVanishesNorExceedsTheOptions) {
  MotionOptions options;
  options.translation_sigma = 0.2;
  options.rotation_sigma = 0.1;
  MotionNoise steady(options);
  AddRandomErrors({0.0, 0.0, 0.0}, 300, kGoodMatch, &steady);
  EXPECT_GE(steady.sigma().head<2>().minCoeff(), 0.01);
  EXPECT_GE(steady.sigma().z(), 0.005);
  EXPECT_LT(steady.sigma().head<2>().maxCoeff(), 0.1);
  MotionNoise wild(options);
  AddRandomErrors({2.0, 2.0, 1.0}, 300, kGoodMatch, &wild);
  EXPECT_TRUE(wild.sigma().isApprox(Eigen::Vector3d(0.2, 0.2, 0.1)));
}

TEST(MotionNoiseTest, MatchesThatKnowLessTellNothing) {
  MotionNoise noise((MotionOptions()));
  AddRandomErrors({0.03, 0.03, 0.03}, 300, kGoodMatch, &noise);
  const Eigen::Vector3d known = noise.sigma();
  // Known to half a metre and half a radian only.
  AddRandomErrors({0.4, 0.4, 0.4}, 300, 4.0 * Eigen::Matrix3d::Identity(), &noise);
  AddRandomErrors({0.0, 0.0, 0.0}, 60, 4.0 * Eigen::Matrix3d::Identity(), &noise);
  EXPECT_TRUE(noise.sigma().isApprox(known, 0.3)) << noise.sigma().transpose() << " was " << known.transpose();
}

TEST(MotionNoiseTest, ARobotThatStandsTellsNothing) {
  MotionNoise noise((MotionOptions()));
  for (int i = 0; i < 300; ++i) noise.Add(SE2(), SE2(), SE2(0.001, 0.0, 0.0), kGoodMatch);
  EXPECT_GT(noise.sigma().minCoeff(), 0.9);
}

TEST(MotionNoiseTest, GrowsWhilePredictionsErrToOneSide) {
  MotionNoise noise((MotionOptions()));
  AddRandomErrors({0.02, 0.02, 0.01}, 300, kGoodMatch, &noise);
  const double before = noise.sigma().x();
  // Braking: each prediction goes 0.1 m too far.
  for (int i = 0; i < 10; ++i) noise.Add(SE2(), SE2(0.3, 0.0, 0.0), SE2(0.2, 0.0, 0.0), kGoodMatch);
  EXPECT_GT(noise.sigma().x(), 2.0 * before);
  EXPECT_LT(noise.sigma().y(), 1.5 * before);
}

TEST(MotionNoiseTest, InertiaAndTheStepBoundWhatWasLearned) {
  MotionOptions options;
  MotionNoise noise(options);
  AddRandomErrors({0.0, 0.0, 0.0}, 300, kGoodMatch, &noise);
  const Eigen::Vector3d learned = noise.sigma();
  EXPECT_TRUE(noise.SigmaAt(0.0, 0.1, 0.2).isApprox(learned));
  // Twice the step, twice the error.
  EXPECT_TRUE(noise.SigmaAt(0.0, 0.05, 0.15).isApprox(2.0 * learned));
  // Within a second a robot may do anything.
  EXPECT_TRUE(noise.SigmaAt(0.0, 1.0, 2.0).isApprox(options.GreatestSigma()));
  // Nothing can be predicted after a long gap.
  EXPECT_TRUE(noise.SigmaAt(0.0, 0.1, 0.9).isApprox(options.GreatestSigma()));
  options.learn_sigma = false;
  EXPECT_TRUE(MotionNoise(options).SigmaAt(0.0, 0.1, 0.2).isApprox(options.GreatestSigma()));
}

}  // namespace
}  // namespace arborslam
