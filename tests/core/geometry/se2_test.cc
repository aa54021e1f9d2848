#include "core/geometry/se2.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kTolerance = 1e-12;

SE2 RandomPose(Random* random) {
  const double x = random->Uniform(-10.0, 10.0);
  const double y = random->Uniform(-10.0, 10.0);
  return SE2(x, y, random->Uniform(-kPi, kPi));
}

Eigen::Vector2d RandomPoint(Random* random) {
  const double x = random->Uniform(-10.0, 10.0);
  return {x, random->Uniform(-10.0, 10.0)};
}

// An independent way to the same motion: the homogeneous matrix.
Eigen::Matrix3d Matrix(const SE2& pose) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(pose.theta()).toRotationMatrix();
  matrix.topRightCorner<2, 1>() = pose.translation();
  return matrix;
}

TEST(SE2Test, DefaultIsTheIdentity) {
  const SE2 identity;
  EXPECT_EQ(identity.vector(), Eigen::Vector3d::Zero());
  EXPECT_EQ(identity * Eigen::Vector2d(1.5, -2.5), Eigen::Vector2d(1.5, -2.5));
  EXPECT_EQ(identity.rotation(), Eigen::Matrix2d::Identity());
}

TEST(SE2Test, MovesAPointAsDrawnByHand) {
  // A quarter turn to the left at (1, 2): ahead is +y, left is -x.
  const SE2 pose(1.0, 2.0, 0.5 * kPi);
  EXPECT_TRUE((pose * Eigen::Vector2d(3.0, 0.0)).isApprox(Eigen::Vector2d(1.0, 5.0), kTolerance));
  EXPECT_TRUE((pose * Eigen::Vector2d(0.0, 1.0)).isApprox(Eigen::Vector2d(0.0, 2.0), kTolerance));
  EXPECT_TRUE((pose * SE2(3.0, 1.0, 0.25 * kPi)).IsApprox(SE2(0.0, 5.0, 0.75 * kPi)));
}

TEST(SE2Test, ThetaIsKeptInItsRange) {
  EXPECT_EQ(SE2(0.0, 0.0, kPi).theta(), -kPi);
  EXPECT_EQ(SE2(0.0, 0.0, -kPi).theta(), -kPi);
  EXPECT_NEAR(SE2(0.0, 0.0, 7.0).theta(), 7.0 - 2.0 * kPi, kTolerance);
  const SE2 product = SE2(0.0, 0.0, 3.0) * SE2(0.0, 0.0, 3.0);
  EXPECT_NEAR(product.theta(), 6.0 - 2.0 * kPi, kTolerance);
  // The inverse of half a turn is half a turn, whose only name is -pi.
  EXPECT_EQ(SE2(1.0, 0.0, -kPi).Inverse().theta(), -kPi);
}

TEST(SE2Test, AgreesWithHomogeneousMatrices) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const SE2 a = RandomPose(&random);
    const SE2 b = RandomPose(&random);
    const Eigen::Vector2d point = RandomPoint(&random);
    EXPECT_LT((Matrix(a * b) - Matrix(a) * Matrix(b)).norm(), kTolerance);
    EXPECT_LT((Matrix(a.Inverse()) - Matrix(a).inverse()).norm(), kTolerance);
    EXPECT_LT(((a * point).homogeneous() - Matrix(a) * point.homogeneous()).norm(), kTolerance);
    EXPECT_LT((a.rotation() - Matrix(a).topLeftCorner<2, 2>()).norm(), kTolerance);
    EXPECT_EQ(a.vector(), Eigen::Vector3d(a.x(), a.y(), a.theta()));
    EXPECT_DOUBLE_EQ(a.cos(), std::cos(a.theta()));
    EXPECT_DOUBLE_EQ(a.sin(), std::sin(a.theta()));
  }
}

TEST(SE2Test, IsAGroup) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const SE2 a = RandomPose(&random);
    const SE2 b = RandomPose(&random);
    const SE2 c = RandomPose(&random);
    EXPECT_TRUE(((a * b) * c).IsApprox(a * (b * c), kTolerance * 10.0));
    EXPECT_TRUE((a * a.Inverse()).IsApprox(SE2(), kTolerance));
    EXPECT_TRUE((a.Inverse() * a).IsApprox(SE2(), kTolerance));
    EXPECT_TRUE((a * SE2()).IsApprox(a, 0.0));
    EXPECT_TRUE((SE2() * a).IsApprox(a, 0.0));
    EXPECT_TRUE((a * b).Inverse().IsApprox(b.Inverse() * a.Inverse(), kTolerance * 10.0));
    const Eigen::Vector2d point = RandomPoint(&random);
    EXPECT_LT(((a * b) * point - a * (b * point)).norm(), kTolerance * 10.0);
  }
}

TEST(SE2Test, AdjointCarriesAPerturbationAcross) {
  constexpr double kStep = 1e-6;
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const SE2 pose = RandomPose(&random);
    Eigen::Matrix3d numeric;
    for (int column = 0; column < 3; ++column) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(column);
      const SE2 ahead = pose * SE2(d.x(), d.y(), d.z()) * pose.Inverse();
      const SE2 behind = pose * SE2(-d.x(), -d.y(), -d.z()) * pose.Inverse();
      numeric.col(column) = (ahead.vector() - behind.vector()) / (2.0 * kStep);
    }
    EXPECT_LT((pose.Adjoint() - numeric).cwiseAbs().maxCoeff(), 1e-7) << pose;
  }
}

TEST(SE2Test, AdjointOfAProductIsTheProductOfAdjoints) {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const SE2 a = RandomPose(&random);
    const SE2 b = RandomPose(&random);
    EXPECT_LT(((a * b).Adjoint() - a.Adjoint() * b.Adjoint()).norm(), 1e-11);
  }
}

TEST(SE2Test, IsApproxKnowsTranslationRotationAndTheSeam) {
  const SE2 pose(1.0, 2.0, kPi - 1e-4);
  EXPECT_TRUE(pose.IsApprox(SE2(1.0, 2.0, -kPi + 1e-4), 3e-4));
  EXPECT_FALSE(pose.IsApprox(SE2(1.0, 2.0, -kPi + 1e-4), 1e-4));
  EXPECT_FALSE(pose.IsApprox(SE2(1.01, 2.0, pose.theta()), 1e-3));
  EXPECT_FALSE(pose.IsApprox(SE2(1.0, 1.99, pose.theta()), 1e-3));
  EXPECT_TRUE(pose.IsApprox(SE2(1.01, 2.0, pose.theta()), 0.011));
}

TEST(SE2Test, InterpolationMeetsItsEnds) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const SE2 a = RandomPose(&random);
    const SE2 b = RandomPose(&random);
    EXPECT_TRUE(Interpolate(a, b, 0.0).IsApprox(a, kTolerance));
    EXPECT_TRUE(Interpolate(a, b, 1.0).IsApprox(b, kTolerance));
    EXPECT_TRUE(Interpolate(a, b, 0.3).IsApprox(Interpolate(b, a, 0.7), kTolerance));
    EXPECT_TRUE(Interpolate(a, a, 0.4).IsApprox(a, kTolerance));
  }
}

TEST(SE2Test, InterpolationGoesStraightAndTurnsTheShortWay) {
  const SE2 a(0.0, 1.0, kPi - 0.1);
  const SE2 b(4.0, -1.0, -kPi + 0.3);
  EXPECT_TRUE(Interpolate(a, b, 0.25).IsApprox(SE2(1.0, 0.5, -kPi), kTolerance));
  EXPECT_TRUE(Interpolate(a, b, 0.5).IsApprox(SE2(2.0, 0.0, -kPi + 0.1), kTolerance));
  EXPECT_TRUE(Interpolate(b, a, 0.5).IsApprox(SE2(2.0, 0.0, -kPi + 0.1), kTolerance));
}

TEST(SE2Test, PrintsItsThreeNumbers) {
  std::ostringstream text;
  text << SE2(1.5, -2.0, 0.25);
  EXPECT_EQ(text.str(), "(1.5, -2, 0.25)");
}

TEST(SE2Test, PosesAreCloseUpToBothLimits) {
  const SE2 pose(1.0, 2.0, 3.1);
  EXPECT_TRUE(AreClose(pose, SE2(1.3, 2.4, 3.1), 0.51, 0.1));
  EXPECT_FALSE(AreClose(pose, SE2(1.3, 2.4, 3.1), 0.49, 0.1));
  // Across the cut at pi.
  EXPECT_TRUE(AreClose(pose, SE2(1.0, 2.0, -3.1), 0.1, 0.09));
  EXPECT_FALSE(AreClose(pose, SE2(1.0, 2.0, -3.1), 0.1, 0.08));
}

}  // namespace
}  // namespace arborslam
