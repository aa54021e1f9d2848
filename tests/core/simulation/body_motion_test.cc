#include "core/simulation/body_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kDuration = 300.0;

struct Extremes {
  double left = 0.0;
  double up = 0.0;
  double tilt = 0.0;
  double yaw = 0.0;
};

Extremes ExtremesOf(const BodyMotion& motion) {
  Extremes extremes;
  for (double time = 0.0; time < kDuration; time += 0.007) {
    const BodyOffset offset = motion.At(time);
    extremes.left = std::max(extremes.left, std::abs(offset.left));
    extremes.up = std::max(extremes.up, std::abs(offset.up));
    extremes.tilt = std::max({extremes.tilt, std::abs(offset.roll), std::abs(offset.pitch)});
    extremes.yaw = std::max(extremes.yaw, std::abs(offset.yaw));
  }
  return extremes;
}

TEST(BodyMotionTest, WheelsAreCalmATrotJoltsAndAHandSways) {
  const Extremes wheeled = ExtremesOf(BodyMotion("wheeled", 1.0, kDuration, 1));
  EXPECT_LT(wheeled.tilt, DegToRad(0.6));
  EXPECT_LT(wheeled.up, 0.005);
  EXPECT_GT(wheeled.tilt, DegToRad(0.1));
  const Extremes trot = ExtremesOf(BodyMotion("trot", 1.0, kDuration, 1));
  EXPECT_GT(trot.tilt, DegToRad(2.5));
  EXPECT_LT(trot.tilt, DegToRad(6.0));
  EXPECT_GT(trot.up, 0.008);
  EXPECT_LT(trot.up, 0.04);
  EXPECT_GT(trot.left, 0.015);
  EXPECT_LT(trot.left, 0.035);
  const Extremes handheld = ExtremesOf(BodyMotion("handheld", 1.0, kDuration, 1));
  EXPECT_GT(handheld.tilt, DegToRad(2.0));
  EXPECT_GT(handheld.yaw, DegToRad(3.0));
  EXPECT_NEAR(handheld.up, 0.03, 0.002);
}

TEST(BodyMotionTest, IsSmoothAlsoWhereFootfallsComeAndGo) {
  const BodyMotion motion("trot", 1.0, 60.0, 2);
  constexpr double kStep = 1e-4;
  BodyOffset before = motion.At(0.0);
  double rate_before = 0.0;
  for (int i = 1; i < 200000; ++i) {
    const BodyOffset now = motion.At(kStep * i);
    const double rate = (now.roll - before.roll) / kStep;
    // A jolt of 3 deg within 0.05 s: at most 37 deg/s, and 1,200 deg/s^2, of which two may coincide.
    ASSERT_LT(std::abs(rate), DegToRad(100.0)) << kStep * i;
    if (i > 1) {
      ASSERT_LT(std::abs(rate - rate_before) / kStep, DegToRad(4000.0)) << kStep * i;
    }
    before = now;
    rate_before = rate;
  }
}

TEST(BodyMotionTest, ScaleMultipliesEverything) {
  for (const std::string& kind : BodyMotion::Kinds()) {
    const BodyMotion one(kind, 1.0, 10.0, 3);
    const BodyMotion half(kind, 0.5, 10.0, 3);
    const BodyMotion none(kind, 0.0, 10.0, 3);
    for (double time = 0.0; time < 10.0; time += 0.13) {
      EXPECT_NEAR(half.At(time).roll, 0.5 * one.At(time).roll, 1e-12);
      EXPECT_NEAR(half.At(time).up, 0.5 * one.At(time).up, 1e-12);
      EXPECT_EQ(none.At(time).yaw, 0.0);
    }
  }
}

TEST(BodyMotionTest, FollowsFromItsSeed) {
  for (const std::string& kind : BodyMotion::Kinds()) {
    const BodyMotion one(kind, 1.0, 10.0, 3);
    const BodyMotion same(kind, 1.0, 10.0, 3);
    const BodyMotion other(kind, 1.0, 10.0, 4);
    EXPECT_EQ(one.At(2.7).pitch, same.At(2.7).pitch);
    EXPECT_NE(one.At(2.7).pitch, other.At(2.7).pitch);
    // Before and after the footfalls there is nothing to go wrong.
    EXPECT_TRUE(std::isfinite(one.At(-100.0).roll));
    EXPECT_TRUE(std::isfinite(one.At(1e6).roll));
  }
}

}  // namespace
}  // namespace arborslam
