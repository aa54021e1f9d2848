#include "core/simulation/uneven_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Eigen::Vector2d kLow(-60.0, -50.0);
const Eigen::Vector2d kHigh(60.0, 50.0);

UnevenGroundOptions Flat() {
  UnevenGroundOptions options;
  options.undulation = 0.0;
  options.bumps = 0.0;
  options.grass_height = 0.0;
  return options;
}

Eigen::Vector3d RandomBeam(Random* random) {
  const double bearing = random->Uniform(-kPi, kPi);
  const double elevation = DegToRad(random->Uniform(-20.0, 16.0));
  return {std::cos(elevation) * std::cos(bearing), std::cos(elevation) * std::sin(bearing), std::sin(elevation)};
}

TEST(UnevenGroundTest, BeamsMeetALevelPlaneWhereTheyShould) {
  const UnevenGround terrain(Flat(), 1, kLow, kHigh);
  Random random(1);
  for (const double degrees : {-90.0, -45.0, -15.0, -5.0, -1.0}) {
    const double elevation = DegToRad(degrees);
    const Eigen::Vector3d direction(std::cos(elevation), 0.0, std::sin(elevation));
    const double expected = 0.5 / std::sin(-elevation);
    EXPECT_NEAR(terrain.Cast({0.0, 0.0, 0.5}, direction, 100.0, &random), expected, 1e-6) << degrees;
    EXPECT_EQ(terrain.Cast({0.0, 0.0, 0.5}, direction, 0.99 * expected, &random), kInfinity) << degrees;
  }
  EXPECT_EQ(terrain.Cast({0.0, 0.0, 0.5}, {1.0, 0.0, 0.0}, 100.0, &random), kInfinity);
  EXPECT_EQ(terrain.Cast({0.0, 0.0, 0.5}, {0.0, 0.0, 1.0}, 100.0, &random), kInfinity);
}

TEST(UnevenGroundTest, BeamsMeetASlope) {
  UnevenGroundOptions options = Flat();
  options.slope = 15.0;
  options.slope_direction = 90.0;
  const UnevenGround terrain(options, 1, kLow, kHigh);
  EXPECT_NEAR(terrain.SmoothHeight({3.0, 10.0}), 10.0 * std::tan(DegToRad(15.0)), 1e-12);
  EXPECT_NEAR(terrain.Height({3.0, -10.0}), -10.0 * std::tan(DegToRad(15.0)), 1e-12);
  // A level beam uphill, half a metre above the ground.
  Random random(1);
  EXPECT_NEAR(terrain.Cast({0.0, 0.0, 0.5}, {0.0, 1.0, 0.0}, 100.0, &random), 0.5 / std::tan(DegToRad(15.0)), 1e-6);
  EXPECT_EQ(terrain.Cast({0.0, 0.0, 0.5}, {0.0, -1.0, 0.0}, 100.0, &random), kInfinity);
}

TEST(UnevenGroundTest, BeamsOverUnevenGroundAgreeWithBruteForceSampling) {
  UnevenGroundOptions options = Flat();
  options.undulation = 0.6;
  options.wavelength = 12.0;
  options.bumps = 0.03;
  options.slope = 4.0;
  options.slope_direction = 30.0;
  const UnevenGround terrain(options, 7, kLow, kHigh);
  Random random(2);
  int hits = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Eigen::Vector2d place(random.Uniform(-10.0, 10.0), random.Uniform(-10.0, 10.0));
    const Eigen::Vector3d origin(place.x(), place.y(), terrain.Height(place) + random.Uniform(0.2, 1.5));
    const Eigen::Vector3d direction = RandomBeam(&random);
    constexpr double kMaxRange = 35.0;
    const double range = terrain.Cast(origin, direction, kMaxRange, &random);
    const auto gap = [&](double at) {
      const Eigen::Vector3d point = origin + at * direction;
      return point.z() - terrain.Height(point.head<2>());
    };
    if (range < kInfinity) {
      ++hits;
      ASSERT_LE(range, terrain.RangeToFloor(origin, direction)) << trial;
      ASSERT_NEAR(gap(range), 0.0, 1e-6) << trial;
    }
    for (double sample = 0.0; sample < std::min(range, kMaxRange) - 1e-6; sample += 0.01) {
      ASSERT_GT(gap(sample), -1e-6) << trial << " " << sample;
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(UnevenGroundTest, WavesAreAsHighAsAskedForAndSmooth) {
  UnevenGroundOptions options = Flat();
  options.undulation = 0.4;
  options.slope = 10.0;
  options.slope_direction = -45.0;
  const UnevenGround terrain(options, 3, kLow, kHigh);
  EXPECT_NEAR(terrain.SmoothHeight({0.0, 0.0}), 0.0, 1e-15);
  const double rise = std::tan(DegToRad(10.0)) / std::sqrt(2.0);
  double highest = 0.0;
  for (double x = kLow.x(); x <= kHigh.x(); x += 0.5) {
    for (double y = kLow.y(); y <= kHigh.y(); y += 0.5) {
      highest = std::max(highest, std::abs(terrain.SmoothHeight({x, y}) - rise * x + rise * y));
      ASSERT_NEAR(terrain.Height({x, y}), terrain.SmoothHeight({x, y}), 2e-3);
    }
  }
  EXPECT_NEAR(highest, 0.4, 0.02);
  Random random(9);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector2d place(random.Uniform(-50.0, 50.0), random.Uniform(-50.0, 50.0));
    const double step = 1e-5;
    const Eigen::Vector2d gradient = terrain.SmoothGradient(place);
    const Eigen::Vector2d dx(step, 0.0);
    const Eigen::Vector2d dy(0.0, step);
    EXPECT_NEAR(gradient.x(), (terrain.SmoothHeight(place + dx) - terrain.SmoothHeight(place - dx)) / (2.0 * step),
                1e-8);
    EXPECT_NEAR(gradient.y(), (terrain.SmoothHeight(place + dy) - terrain.SmoothHeight(place - dy)) / (2.0 * step),
                1e-8);
  }
}

TEST(UnevenGroundTest, GrassStopsBeamsAsOftenAsItsDensitySays) {
  UnevenGroundOptions options = Flat();
  options.grass_height = 0.2;
  options.grass_cover = 0.7;
  options.grass_clumps = 0.05;
  options.grass_density = 1.5;
  const UnevenGround terrain(options, 5, kLow, kHigh);
  Random random(6);
  for (int trial = 0; trial < 12; ++trial) {
    const double elevation = DegToRad(random.Uniform(-12.0, -2.0));
    const double bearing = random.Uniform(-kPi, kPi);
    const Eigen::Vector3d direction(std::cos(elevation) * std::cos(bearing), std::cos(elevation) * std::sin(bearing),
                                    std::sin(elevation));
    const Eigen::Vector3d origin(0.0, 0.0, 0.6);
    const double soil = 0.6 / std::sin(-elevation);
    // How much of the beam lies in the grass.
    constexpr double kStep = 0.001;
    double within = 0.0;
    for (double range = 0.0; range < soil; range += kStep) {
      const Eigen::Vector3d point = origin + range * direction;
      if (point.z() < terrain.GrassHeight(point.head<2>())) within += kStep;
    }
    constexpr int kDraws = 4000;
    int blades = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const double range = terrain.Cast(origin, direction, 100.0, &random);
      ASSERT_LE(range, soil + 1e-6);
      if (range > soil - 1e-6) continue;
      const Eigen::Vector3d point = origin + range * direction;
      ASSERT_LT(point.z(), terrain.GrassHeight(point.head<2>()));
      ++blades;
    }
    const double expected = 1.0 - std::exp(-options.grass_density * within);
    const double deviation = std::sqrt(expected * (1.0 - expected) / kDraws);
    EXPECT_NEAR(static_cast<double>(blades) / kDraws, expected, 4.0 * deviation + 0.01) << trial;
  }
}

TEST(UnevenGroundTest, GrassCoversTheShareAskedFor) {
  UnevenGroundOptions options = Flat();
  options.grass_height = 0.1;
  options.grass_cover = 0.3;
  options.grass_clumps = 0.0;
  const UnevenGround terrain(options, 5, kLow, kHigh);
  int grown = 0;
  int places = 0;
  for (double x = -50.0; x < 50.0; x += 0.25) {
    for (double y = -40.0; y < 40.0; y += 0.25) {
      const double height = terrain.GrassHeight({x, y});
      ASSERT_LE(height, 0.1 + 1e-6);
      grown += height > 0.0 ? 1 : 0;
      ++places;
    }
  }
  EXPECT_NEAR(static_cast<double>(grown) / places, 0.3, 0.05);
}

TEST(UnevenGroundTest, FollowsFromItsSeed) {
  const UnevenGroundOptions options;
  const UnevenGround one(options, 1, kLow, kHigh);
  const UnevenGround same(options, 1, kLow, kHigh);
  const UnevenGround other(options, 2, kLow, kHigh);
  EXPECT_EQ(one.Height({7.3, -2.1}), same.Height({7.3, -2.1}));
  EXPECT_NE(one.Height({7.3, -2.1}), other.Height({7.3, -2.1}));
  EXPECT_NE(one.SmoothHeight({7.3, -2.1}), other.SmoothHeight({7.3, -2.1}));
}

TEST(UnevenGroundOptionsTest, RefusesWhatCannotBe) {
  EXPECT_EQ(UnevenGroundOptions().Validate(), "");
  const auto problem = [](double UnevenGroundOptions::*field, double value) {
    UnevenGroundOptions options;
    options.*field = value;
    return options.Validate();
  };
  EXPECT_NE(problem(&UnevenGroundOptions::undulation, -0.1), "");
  EXPECT_NE(problem(&UnevenGroundOptions::wavelength, 0.0), "");
  EXPECT_NE(problem(&UnevenGroundOptions::slope, 31.0), "");
  EXPECT_NE(problem(&UnevenGroundOptions::slope_direction, 361.0), "");
  EXPECT_NE(problem(&UnevenGroundOptions::bumps, 0.3), "");
  EXPECT_NE(problem(&UnevenGroundOptions::grass_height, -1.0), "");
  EXPECT_NE(problem(&UnevenGroundOptions::grass_cover, 1.1), "");
  EXPECT_NE(problem(&UnevenGroundOptions::grass_clumps, -0.1), "");
  EXPECT_EQ(problem(&UnevenGroundOptions::grass_density, 0.0), "grass_density is 0.0, must lie in (0, 1000]");
}

}  // namespace
}  // namespace arborslam
