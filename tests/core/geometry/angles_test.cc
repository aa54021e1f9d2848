#include "core/geometry/angles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Shortest way around the circle between two angles, by their sines and cosines.
double Apart(double a, double b) { return std::hypot(std::cos(a) - std::cos(b), std::sin(a) - std::sin(b)); }

TEST(AnglesTest, WrapsKnownAngles) {
  EXPECT_EQ(NormalizeAngle(0.0), 0.0);
  EXPECT_EQ(NormalizeAngle(-kPi), -kPi);
  EXPECT_EQ(NormalizeAngle(kPi), -kPi);
  EXPECT_EQ(NormalizeAngle(2.0 * kPi), 0.0);
  EXPECT_EQ(NormalizeAngle(-2.0 * kPi), 0.0);
  EXPECT_NEAR(NormalizeAngle(1.5 * kPi), -0.5 * kPi, 1e-15);
  EXPECT_NEAR(NormalizeAngle(-1.5 * kPi), 0.5 * kPi, 1e-15);
  EXPECT_NEAR(NormalizeAngle(7.0), 7.0 - 2.0 * kPi, 1e-15);
}

TEST(AnglesTest, LeavesAnglesInRangeAsTheyAre) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double angle = random.Uniform(-kPi, kPi);
    EXPECT_EQ(NormalizeAngle(angle), angle);
    EXPECT_EQ(NormalizeAngle(1e-12 * angle), 1e-12 * angle);
  }
}

TEST(AnglesTest, NeighboursOfOddMultiplesOfPiStayInRange) {
  for (const double turn : {-1001.0, -5.0, -3.0, -1.0, 1.0, 3.0, 5.0, 7.0, 1001.0, 1e6 + 1.0}) {
    double below = turn * kPi;
    double above = below;
    for (int i = 0; i < 50; ++i) {
      for (const double angle : {below, above}) {
        const double wrapped = NormalizeAngle(angle);
        EXPECT_GE(wrapped, -kPi) << std::hexfloat << angle;
        EXPECT_LT(wrapped, kPi) << std::hexfloat << angle;
        EXPECT_NEAR(std::abs(wrapped), kPi, 1e-7) << std::hexfloat << angle;
      }
      below = std::nextafter(below, -kInfinity);
      above = std::nextafter(above, kInfinity);
    }
  }
}

TEST(AnglesTest, WrappedAnglesPointTheSameWay) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const double angle = random.Uniform(-100.0, 100.0);
    const double wrapped = NormalizeAngle(angle);
    EXPECT_GE(wrapped, -kPi);
    EXPECT_LT(wrapped, kPi);
    EXPECT_LT(Apart(angle, wrapped), 1e-13);
  }
}

TEST(AnglesTest, DoesNotHideWhatIsNoAngle) {
  EXPECT_TRUE(std::isnan(NormalizeAngle(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(NormalizeAngle(kInfinity)));
  EXPECT_TRUE(std::isnan(NormalizeAngle(-kInfinity)));
}

TEST(AnglesTest, DifferenceTakesTheShortWay) {
  EXPECT_NEAR(AngleDifference(kPi - 0.1, -kPi + 0.1), -0.2, 1e-15);
  EXPECT_NEAR(AngleDifference(-kPi + 0.1, kPi - 0.1), 0.2, 1e-15);
  EXPECT_NEAR(AngleDifference(0.3, 0.1), 0.2, 1e-15);
  EXPECT_EQ(AngleDifference(kPi, -kPi), 0.0);
  EXPECT_EQ(AngleDifference(-kPi, kPi), 0.0);
  EXPECT_EQ(AngleDifference(kPi, 0.0), -kPi);
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const double from = random.Uniform(-20.0, 20.0);
    const double to = random.Uniform(-20.0, 20.0);
    const double difference = AngleDifference(to, from);
    EXPECT_LE(std::abs(difference), kPi);
    EXPECT_LT(Apart(from + difference, to), 1e-13);
  }
}

TEST(AnglesTest, DegreesAndRadians) {
  EXPECT_DOUBLE_EQ(DegToRad(180.0), kPi);
  EXPECT_DOUBLE_EQ(DegToRad(-90.0), -0.5 * kPi);
  EXPECT_DOUBLE_EQ(RadToDeg(0.25 * kPi), 45.0);
  EXPECT_DOUBLE_EQ(RadToDeg(DegToRad(17.3)), 17.3);
}

}  // namespace
}  // namespace arborslam
