#include "core/simulation/spline_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

ClosedPath Rectangle() { return ClosedPath({{0.0, 0.0}, {6.0, 0.0}, {6.0, 2.0}, {-2.0, 2.0}, {-2.0, 0.0}}, 0.5); }

TEST(SplinePathTest, FollowsThePathCloselyWithoutWander) {
  const ClosedPath path = Rectangle();
  const SplinePath spline(path, 0.2, 0.0, 1);
  EXPECT_NEAR(spline.Length(), path.Length(), 1e-9);
  for (double distance = 0.0; distance < path.Length(); distance += 0.01) {
    const SE2 expected = path.At(distance);
    const SE2 actual = spline.At(distance);
    ASSERT_LT((actual.translation() - expected.translation()).norm(), 0.02) << distance;
    ASSERT_LT(std::abs(AngleDifference(actual.theta(), expected.theta())), 0.15) << distance;
  }
  EXPECT_NEAR(spline.At(0.0).x(), 0.0, 1e-9);
  EXPECT_NEAR(spline.At(0.0).y(), 0.0, 1e-9);
  EXPECT_NEAR(spline.At(0.0).theta(), 0.0, 1e-9);
}

TEST(SplinePathTest, HeadingIsTheDirectionOfTravelAndHasNoJumps) {
  const SplinePath spline(Rectangle(), 0.2, 0.3, 4);
  const double step = 1e-4;
  for (double distance = 0.0; distance < 2.0 * spline.Length(); distance += 0.013) {
    const SE2 here = spline.At(distance);
    const Eigen::Vector2d travel = spline.At(distance + step).translation() - spline.At(distance - step).translation();
    ASSERT_LT(std::abs(AngleDifference(std::atan2(travel.y(), travel.x()), here.theta())), 1e-4) << distance;
    ASSERT_NEAR(travel.norm() / (2.0 * step), 1.0, 0.25) << distance;
    // The curvature stays near that of the turns, 2 per metre, and so do its differences over a tenth of a millimetre.
    const double turn = AngleDifference(spline.At(distance + step).theta(), here.theta()) / step;
    const double turn_before = AngleDifference(here.theta(), spline.At(distance - step).theta()) / step;
    ASSERT_LT(std::abs(turn), 4.0) << distance;
    ASSERT_LT(std::abs(turn - turn_before), 0.02) << distance;
  }
}

TEST(SplinePathTest, GoesAroundAgainInBothDirections) {
  const SplinePath spline(Rectangle(), 0.2, 0.2, 4);
  for (const double distance : {0.0, 3.3, 11.7}) {
    EXPECT_TRUE(spline.At(distance).IsApprox(spline.At(distance + spline.Length()), 1e-9));
    EXPECT_TRUE(spline.At(distance).IsApprox(spline.At(distance - 2.0 * spline.Length()), 1e-9));
  }
}

TEST(SplinePathTest, WanderIsBoundedAndFollowsFromTheSeed) {
  const ClosedPath path = Rectangle();
  const SplinePath straight(path, 0.2, 0.0, 1);
  const SplinePath one(path, 0.2, 0.3, 1);
  const SplinePath other(path, 0.2, 0.3, 2);
  double widest = 0.0;
  double difference = 0.0;
  for (double distance = 0.0; distance < path.Length(); distance += 0.1) {
    const Eigen::Vector2d stray = one.At(distance).translation() - straight.At(distance).translation();
    widest = std::max(widest, stray.norm());
    difference = std::max(difference, (one.At(distance).translation() - other.At(distance).translation()).norm());
  }
  EXPECT_GT(widest, 0.05);
  EXPECT_LT(widest, 0.31);
  EXPECT_GT(difference, 0.02);
}

}  // namespace
}  // namespace arborslam
