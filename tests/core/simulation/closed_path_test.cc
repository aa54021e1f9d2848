#include "core/simulation/closed_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

const std::vector<Eigen::Vector2d> kSquare = {{0.0, 0.0}, {5.0, 0.0}, {10.0, 0.0}, {10.0, 10.0}, {0.0, 10.0}};

TEST(ClosedPathTest, SquareWithRoundCornersHasItsLength) {
  // The corner at the origin is a corner too; (5, 0) is not.
  const ClosedPath path(kSquare, 1.0);
  EXPECT_NEAR(path.Length(), 4.0 * 8.0 + 2.0 * kPi, 1e-12);
  EXPECT_TRUE(path.At(0.0).IsApprox(SE2(1.0, 0.0, 0.0)));
  EXPECT_TRUE(path.At(4.0).IsApprox(SE2(5.0, 0.0, 0.0)));
  EXPECT_TRUE(path.At(8.0 + kPi / 4.0).IsApprox(SE2(9.0 + std::sqrt(0.5), 1.0 - std::sqrt(0.5), kPi / 4.0)));
  EXPECT_TRUE(path.At(8.0 + kPi / 2.0).IsApprox(SE2(10.0, 1.0, kPi / 2.0)));
  EXPECT_TRUE(path.At(path.Length() - kPi / 4.0).IsApprox(SE2(1.0 - std::sqrt(0.5), 1.0 - std::sqrt(0.5), -kPi / 4.0)));
}

TEST(ClosedPathTest, SharpCornersWithoutRadius) {
  const ClosedPath path(kSquare, 0.0);
  EXPECT_NEAR(path.Length(), 40.0, 1e-12);
  EXPECT_TRUE(path.At(12.0).IsApprox(SE2(10.0, 2.0, kPi / 2.0)));
}

TEST(ClosedPathTest, GoesAroundAgain) {
  const ClosedPath path(kSquare, 0.7);
  for (double distance = 0.0; distance < path.Length(); distance += 0.37) {
    EXPECT_TRUE(path.At(distance).IsApprox(path.At(distance + 3.0 * path.Length())));
    EXPECT_TRUE(path.At(distance).IsApprox(path.At(distance - path.Length())));
  }
}

TEST(ClosedPathTest, IsContinuousTangentAndMeasuredByItsLength) {
  // Left and right turns, one of them with less room than the radius asks for.
  const std::vector<Eigen::Vector2d> corners = {{0.0, 0.0}, {6.0, 0.0},  {6.0, 1.0}, {9.0, 1.0},
                                                {9.0, 7.0}, {-4.0, 8.0}, {-2.0, 0.0}};
  const ClosedPath path(corners, 0.8);
  constexpr double kStep = 1e-4;
  for (double distance = 0.0; distance < path.Length(); distance += 0.01) {
    const SE2 here = path.At(distance);
    const SE2 motion = here.Inverse() * path.At(distance + kStep);
    EXPECT_NEAR(motion.translation().norm(), kStep, 1e-7) << distance;
    EXPECT_NEAR(motion.y(), 0.0, 1e-7) << distance;
    EXPECT_LE(std::abs(motion.theta()), kStep / 0.4) << distance;
  }
}

}  // namespace
}  // namespace arborslam
