#include "core/simulation/planar_lidar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

PlanarLidarOptions Exact() {
  PlanarLidarOptions options;
  options.range_noise = 0.0;
  options.range_resolution = 0.0;
  options.drop_out = 0.0;
  options.ground_roughness = 0.0;
  return options;
}

LaserScan MeasureExact(const PlanarWorld& world, const SE2& pose, const Tilt& tilt = Tilt{}) {
  Random random(1);
  return PlanarLidar(Exact()).Measure(world, pose, 0.0, tilt, &random);
}

TEST(PlanarLidarTest, GeometryIsThatOfThePullallyRecordings) {
  Random random(1);
  const LaserScan scan = PlanarLidar(Exact()).Measure({}, SE2(), 3.5, Tilt{}, &random);
  ASSERT_EQ(scan.ranges.size(), 897u);
  EXPECT_EQ(scan.stamp, 3.5);
  EXPECT_DOUBLE_EQ(scan.Bearing(0), -kPi);
  EXPECT_NEAR(scan.Bearing(1) - scan.Bearing(0), 2.0 * kPi / 898.0, 1e-15);
  for (const float range : scan.ranges) EXPECT_EQ(range, std::numeric_limits<float>::infinity());
}

TEST(PlanarLidarTest, BeamAheadHitsTheFrontOfADisc) {
  PlanarWorld world;
  world.discs = {{{7.0, 2.0}, 0.25}};
  // The robot at (3, 2) looks along +x: beam 449 has bearing 0.
  const LaserScan scan = MeasureExact(world, SE2(3.0, 2.0, 0.0));
  EXPECT_NEAR(scan.Bearing(449), 0.0, 1e-12);
  EXPECT_FLOAT_EQ(scan.ranges[449], 3.75f);
  // Turned to +y, the disc is on the right: beam 224.5 has bearing -pi/2.
  const LaserScan turned = MeasureExact(world, SE2(3.0, 2.0, kPi / 2.0));
  EXPECT_NEAR(turned.ranges[224], 3.75f, 1e-3);
  EXPECT_FALSE(std::isfinite(turned.ranges[449]));
}

// The range to the nearest surface along a ray, found by solving |p + r u - c|^2 = radius^2 and by the distances of the
// wall's ends from the ray.
double NearestHit(const PlanarWorld& world, const Eigen::Vector2d& position, double angle) {
  const Eigen::Vector2d u(std::cos(angle), std::sin(angle));
  const Eigen::Vector2d left(-u.y(), u.x());
  double nearest = std::numeric_limits<double>::infinity();
  for (const Disc& disc : world.discs) {
    const Eigen::Vector2d offset = position - disc.center;
    const double b = offset.dot(u);
    const double c = offset.squaredNorm() - disc.radius * disc.radius;
    const double discriminant = b * b - c;
    if (discriminant < 0.0) continue;
    for (const double root : {-b - std::sqrt(discriminant), -b + std::sqrt(discriminant)}) {
      if (root > 0.0) nearest = std::min(nearest, root);
    }
  }
  for (const Wall& wall : world.walls) {
    const double side_begin = (wall.begin - position).dot(left);
    const double side_end = (wall.end - position).dot(left);
    if (side_begin * side_end > 0.0 || side_begin == side_end) continue;
    const double t = side_begin / (side_begin - side_end);
    const double range = ((1.0 - t) * wall.begin + t * wall.end - position).dot(u);
    if (range > 0.0) nearest = std::min(nearest, range);
  }
  return nearest;
}

TEST(PlanarLidarTest, EveryBeamEqualsTheAnalyticHitInRandomWorlds) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int hits = 0;
  for (int trial = 0; trial < 40; ++trial) {
    PlanarWorld world;
    for (int i = 0; i < 25; ++i) {
      world.discs.push_back({{40.0 * unit(generator) - 20.0, 40.0 * unit(generator) - 20.0}, 0.05 + unit(generator)});
    }
    for (int i = 0; i < 3; ++i) {
      world.walls.push_back({{40.0 * unit(generator) - 20.0, 40.0 * unit(generator) - 20.0},
                             {40.0 * unit(generator) - 20.0, 40.0 * unit(generator) - 20.0},
                             0.0});
    }
    const SE2 pose(10.0 * unit(generator), 10.0 * unit(generator), 7.0 * unit(generator));
    const LaserScan scan = MeasureExact(world, pose);
    for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      const double expected = NearestHit(world, pose.translation(), pose.theta() + scan.Bearing(beam));
      const bool visible = expected >= 0.3 && expected <= 30.0;
      ASSERT_EQ(std::isfinite(scan.ranges[beam]), visible) << trial << " " << beam << " " << expected;
      if (!visible) continue;
      ++hits;
      ASSERT_NEAR(scan.ranges[beam], expected, 1e-5 * expected) << trial << " " << beam;
    }
  }
  EXPECT_GT(hits, 10000);
}

TEST(PlanarLidarTest, SeesAllOfADiscBehindIt) {
  PlanarWorld world;
  world.discs = {{{-2.0, 0.0}, 0.5}};
  const LaserScan scan = MeasureExact(world, SE2());
  int hits = 0;
  for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!std::isfinite(scan.ranges[beam])) continue;
    ++hits;
    EXPECT_GT(std::abs(scan.Bearing(beam)), kPi - std::asin(0.25) - 1e-9);
  }
  // 2 asin(1/4) / (2 pi / 898) = 72.2 slots, one of which has no beam.
  EXPECT_EQ(hits, 72);
}

TEST(PlanarLidarTest, InsideADiscEveryBeamHitsItsRim) {
  PlanarWorld world;
  world.discs = {{{0.0, 0.0}, 2.0}};
  for (const float range : MeasureExact(world, SE2(0.0, 0.0, 0.3)).ranges) EXPECT_FLOAT_EQ(range, 2.0f);
}

TEST(PlanarLidarTest, RangeLimitsHideAndDoNotUncover) {
  PlanarWorld world;
  world.discs = {{{31.0, 0.0}, 0.5}, {{-0.5, 0.0}, 0.3}, {{-5.0, 0.0}, 0.3}};
  const LaserScan scan = MeasureExact(world, SE2());
  EXPECT_FALSE(std::isfinite(scan.ranges[449])) << "30.5 m is out of range";
  EXPECT_FALSE(std::isfinite(scan.ranges[0])) << "the near disc hides the far one";
}

TEST(PlanarLidarTest, NoiseHasItsSpreadAndBeamsDropOut) {
  PlanarLidarOptions options;
  options.range_noise = 0.03;
  options.range_resolution = 0.0;
  options.drop_out = 0.1;
  PlanarWorld world;
  world.discs = {{{0.0, 0.0}, 5.0}};
  const PlanarLidar lidar(options);
  double sum = 0.0;
  double square = 0.0;
  int kept = 0;
  int beams = 0;
  for (int scan_index = 0; scan_index < 100; ++scan_index) {
    Random random(3, scan_index);
    for (const float range : lidar.Measure(world, SE2(), 0.0, Tilt{}, &random).ranges) {
      ++beams;
      if (!std::isfinite(range)) continue;
      ++kept;
      sum += range - 5.0;
      square += (range - 5.0) * (range - 5.0);
    }
  }
  // Four standard errors each.
  EXPECT_NEAR(sum / kept, 0.0, 4.0 * 0.03 / std::sqrt(kept));
  EXPECT_NEAR(std::sqrt(square / kept), 0.03, 4.0 * 0.03 / std::sqrt(2.0 * kept));
  EXPECT_NEAR(static_cast<double>(kept) / beams, 0.9, 4.0 * std::sqrt(0.09 / beams));
}

TEST(PlanarLidarTest, RangesAreMultiplesOfTheResolution) {
  PlanarLidarOptions options;
  options.range_resolution = 0.01;
  PlanarWorld world;
  world.walls = {{{4.0, -20.0}, {4.0, 20.0}, 0.0}};
  Random random(1);
  int hits = 0;
  for (const float range : PlanarLidar(options).Measure(world, SE2(), 0.0, Tilt{}, &random).ranges) {
    if (!std::isfinite(range)) continue;
    ++hits;
    EXPECT_NEAR(range * 100.0, std::round(range * 100.0), 2e-3);
  }
  EXPECT_GT(hits, 100);
}

TEST(PlanarLidarTest, FoliageReturnsAsBeersLawSays) {
  constexpr double kDensity = 0.8;
  constexpr double kRadius = 0.6;
  PlanarWorld world;
  world.foliage = {{{5.0, 0.0}, kRadius, kDensity}};
  const PlanarLidar lidar(Exact());
  constexpr int kScans = 20000;
  int hits = 0;
  double depths = 0.0;
  for (int i = 0; i < kScans; ++i) {
    Random random(9, i);
    const float range = lidar.Measure(world, SE2(), 0.0, Tilt{}, &random).ranges[449];
    if (!std::isfinite(range)) continue;
    ASSERT_GE(range, 4.4f - 1e-5f);
    ASSERT_LE(range, 5.6f + 1e-5f);
    ++hits;
    depths += range - 4.4;
  }
  const double chord = 2.0 * kRadius;
  const double passed = std::exp(-kDensity * chord);
  EXPECT_NEAR(static_cast<double>(hits) / kScans, 1.0 - passed, 4.0 * std::sqrt(passed * (1.0 - passed) / kScans));
  // Mean of an exponential distribution cut off at the chord.
  const double mean_depth = 1.0 / kDensity - chord * passed / (1.0 - passed);
  EXPECT_NEAR(depths / hits, mean_depth, 4.0 * chord / std::sqrt(12.0 * hits));
}

TEST(PlanarLidarTest, FoliageDoesNotHideWhatIsInFrontOfItAndNotAllBehind) {
  PlanarWorld world;
  world.discs = {{{8.0, 0.0}, 0.2}};
  world.foliage = {{{5.0, 0.0}, 0.5, 1.0}};
  const PlanarLidar lidar(Exact());
  int trunk = 0;
  int leaves = 0;
  for (int i = 0; i < 500; ++i) {
    Random random(9, i);
    const float range = lidar.Measure(world, SE2(), 0.0, Tilt{}, &random).ranges[449];
    if (std::abs(range - 7.8f) < 1e-4f) {
      ++trunk;
    } else if (range < 5.5f) {
      ++leaves;
    }
  }
  EXPECT_EQ(trunk + leaves, 500);
  EXPECT_GT(trunk, 100);
  EXPECT_GT(leaves, 200);
  world.discs = {{{3.0, 0.0}, 0.2}};
  Random random(9);
  EXPECT_FLOAT_EQ(lidar.Measure(world, SE2(), 0.0, Tilt{}, &random).ranges[449], 2.8f);
}

TEST(PlanarLidarTest, RoughWallsReturnFromBehindTheirLine) {
  PlanarWorld world;
  world.walls = {{{4.0, -0.5}, {4.0, 0.5}, 0.1}};
  const PlanarLidar lidar(Exact());
  double depths = 0.0;
  constexpr int kScans = 2000;
  for (int i = 0; i < kScans; ++i) {
    Random random(2, i);
    const float range = lidar.Measure(world, SE2(), 0.0, Tilt{}, &random).ranges[449];
    ASSERT_GE(range, 4.0f);
    depths += range - 4.0;
  }
  EXPECT_NEAR(depths / kScans, 0.1, 4.0 * 0.1 / std::sqrt(kScans));
}

TEST(PlanarLidarTest, ATiltedScanMeetsTheGroundInALine) {
  const double angle = 0.15;
  const double distance = 0.45 / std::tan(angle);
  PlanarWorld world;
  world.discs = {{{2.0, 0.0}, 0.2}, {{8.0, 0.0}, 2.0}, {{-6.0, 0.0}, 0.2}};
  const LaserScan scan = MeasureExact(world, SE2(), {angle, 0.0});
  EXPECT_FLOAT_EQ(scan.ranges[449], 1.8f) << "the near trunk stands before the ground";
  EXPECT_NEAR(scan.ranges[0], 5.8, 1e-5) << "the plane rises at the back";
  int ground = 0;
  for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (std::abs(scan.Bearing(beam)) > 1.3 || std::abs(scan.Bearing(beam)) < 0.11) continue;
    EXPECT_NEAR(scan.ranges[beam] * std::cos(scan.Bearing(beam)), distance, 1e-4);
    ++ground;
  }
  EXPECT_GT(ground, 300);
}

TEST(PlanarLidarOptionsTest, ValidateNamesTheKey) {
  EXPECT_EQ(PlanarLidarOptions().Validate(), "");
  const auto problem = [](auto change) {
    PlanarLidarOptions options;
    change(&options);
    return options.Validate();
  };
  EXPECT_EQ(problem([](auto* o) { o->beams = 2; }), "beams is 2, must lie in [3, 100000]");
  EXPECT_EQ(problem([](auto* o) { o->max_range = 0.1; }), "max_range is 0.1, must lie in (min_range, 1000]");
  EXPECT_EQ(problem([](auto* o) { o->drop_out = 1.5; }), "drop_out is 1.5, must lie in [0, 1]");
  EXPECT_NE(problem([](auto* o) { o->range_noise = std::nan(""); }), "");
  EXPECT_NE(problem([](auto* o) { o->min_range = -1.0; }), "");
  EXPECT_NE(problem([](auto* o) { o->range_resolution = -0.1; }), "");
  EXPECT_NE(problem([](auto* o) { o->sensor_height = 0.0; }), "");
  EXPECT_NE(problem([](auto* o) { o->ground_roughness = -0.1; }), "");
}

}  // namespace
}  // namespace arborslam
