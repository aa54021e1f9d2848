#include "frontend/tracking/planar_velocity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/se2.h"

namespace arborslam {
namespace {

// On a circle, of which an exact step is known, from anywhere on the map.
TEST(PlanarVelocityTest, IsThatOfACircle) {
  constexpr double kRate = 0.8;    // [rad/s]
  constexpr double kRadius = 2.5;  // [m]
  constexpr double kTime = 0.25;   // [s]
  const double turn = kRate * kTime;
  const SE2 step(kRadius * std::sin(turn), kRadius * (1.0 - std::cos(turn)), turn);
  const SE2 from(4.0, -7.0, 2.9);
  const PlanarVelocity velocity = VelocityBetween({10.0, from}, {10.0 + kTime, from * step});
  EXPECT_NEAR(velocity.angular, kRate, 1e-12);
  // The chord is shorter than the arc.
  EXPECT_NEAR(velocity.linear.x(), kRadius * kRate * std::sin(0.5 * turn) / (0.5 * turn), 1e-9);
  EXPECT_NEAR(velocity.linear.y(), 0.0, 1e-9);
}

TEST(PlanarVelocityTest, HasSidewaysAndStandingRobots) {
  const SE2 from(1.0, 2.0, 1.5);
  const PlanarVelocity sideways = VelocityBetween({0.0, from}, {0.5, from * SE2(0.0, 0.2, 0.0)});
  EXPECT_NEAR((sideways.linear - Eigen::Vector2d(0.0, 0.4)).norm(), 0.0, 1e-12);
  EXPECT_EQ(sideways.angular, 0.0);
  const PlanarVelocity standing = VelocityBetween({0.0, from}, {0.5, from});
  EXPECT_NEAR(standing.linear.norm(), 0.0, 1e-12);
  EXPECT_EQ(standing.angular, 0.0);
}

}  // namespace
}  // namespace arborslam
