#include "core/simulation/lidar3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Lidar3Options Exact() {
  Lidar3Options options;
  options.range_noise = 0.0;
  options.range_resolution = 0.0;
  options.drop_out = 0.0;
  return options;
}

World3 FlatWorld() {
  UnevenGroundOptions options;
  options.undulation = 0.0;
  options.bumps = 0.0;
  options.grass_height = 0.0;
  return {UnevenGround(options, 1, {-120.0, -120.0}, {120.0, 120.0}), {}, {}, {}};
}

Eigen::Isometry3d At(double x, double y, double z, double yaw = 0.0, double pitch = 0.0, double roll = 0.0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(x, y, z));
  pose.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  pose.rotate(Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()));
  pose.rotate(Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()));
  return pose;
}

LidarSweep MeasureAt(const Lidar3Options& options, const World3& world, const Eigen::Isometry3d& pose,
                     uint64_t seed = 1) {
  Random random(seed);
  return Lidar3(options, &world).Measure([&](double) { return pose; }, 3.0, &random);
}

TEST(Lidar3Test, RingsDrawCirclesOnLevelGround) {
  const World3 world = FlatWorld();
  const LidarSweep sweep = MeasureAt(Exact(), world, At(0.0, 0.0, 0.5));
  EXPECT_EQ(sweep.start, 3.0);
  EXPECT_EQ(sweep.duration, 0.1);
  // The eight rings below the horizon: -15, -13 ... -1 deg.
  ASSERT_EQ(sweep.points.size(), 8u * 1800u);
  ASSERT_EQ(sweep.times.size(), sweep.points.size());
  for (size_t i = 0; i < sweep.points.size(); ++i) {
    const size_t column = i / 8;
    const double elevation = DegToRad(-15.0 + 2.0 * static_cast<double>(i % 8));
    const Eigen::Vector3d point = sweep.points[i].cast<double>();
    ASSERT_NEAR(point.z(), -0.5, 1e-5);
    ASSERT_NEAR(point.head<2>().norm(), 0.5 / std::tan(-elevation), 1e-4);
    // From the back on clockwise: the first quarter of the sweep looks to the left.
    const double bearing = kPi - 2.0 * kPi * static_cast<double>(column) / 1800.0;
    ASSERT_NEAR(AngleDifference(std::atan2(point.y(), point.x()), bearing), 0.0, 1e-5);
    ASSERT_NEAR(sweep.times[i], 0.1 * static_cast<double>(column) / 1800.0, 1e-8);
  }
}

TEST(Lidar3Test, EveryBeamEndsAtTheNearestSolid) {
  Random layout(5);
  int hits = 0;
  for (int trial = 0; trial < 10; ++trial) {
    World3 world = FlatWorld();
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d base(layout.Uniform(-30.0, 30.0), layout.Uniform(-30.0, 30.0), -0.2);
      if (base.head<2>().norm() < 3.0) continue;
      const Eigen::Vector3d lean(layout.Uniform(-0.5, 0.5), layout.Uniform(-0.5, 0.5), layout.Uniform(0.5, 6.0));
      world.solids.push_back(Frustum::Between(base, base + lean, layout.Uniform(0.05, 0.5), layout.Uniform(0.0, 0.5)));
    }
    const Eigen::Isometry3d pose = At(layout.Uniform(-1.0, 1.0), layout.Uniform(-1.0, 1.0), layout.Uniform(0.4, 1.5),
                                      layout.Uniform(-kPi, kPi), layout.Uniform(-0.1, 0.1), layout.Uniform(-0.1, 0.1));
    Lidar3Options options = Exact();
    options.columns = 360;
    options.max_range = 25.0;
    const LidarSweep sweep = MeasureAt(options, world, pose);
    size_t next = 0;
    for (int column = 0; column < options.columns; ++column) {
      const double bearing = kPi - 2.0 * kPi * column / options.columns;
      for (int ring = 0; ring < 16; ++ring) {
        const double elevation = DegToRad(-15.0 + 2.0 * ring);
        const Eigen::Vector3d ray(std::cos(elevation) * std::cos(bearing), std::cos(elevation) * std::sin(bearing),
                                  std::sin(elevation));
        const Eigen::Vector3d direction = pose.linear() * ray;
        double expected = direction.z() < 0.0 ? pose.translation().z() / -direction.z() : kInfinity;
        for (const Frustum& solid : world.solids) {
          expected = std::min(expected, Intersect(solid, pose.translation(), direction));
        }
        if (std::abs(expected - options.max_range) < 1e-6) continue;  // On the verge.
        if (!(expected >= options.min_range && expected <= options.max_range)) continue;
        ++hits;
        ASSERT_LT(next, sweep.points.size());
        ASSERT_NEAR((sweep.points[next].cast<double>() - expected * ray).norm(), 0.0, 1e-4)
            << trial << " " << column << " " << ring;
        ++next;
      }
    }
    ASSERT_EQ(next, sweep.points.size());
  }
  EXPECT_GT(hits, 10000);
}

TEST(Lidar3Test, LeavesLetThroughWhatBeersLawSays) {
  World3 world = FlatWorld();
  Leaves leaves;
  leaves.shape = Leaves::Shape::kBox;
  leaves.center = {6.0, 0.0, 1.0};
  leaves.extent = {0.5, 4.0, 1.0};
  leaves.density = 0.8;
  world.leaves.push_back(leaves);
  world.solids.push_back(Frustum::Between({8.0, 0.0, -1.0}, {8.0, 0.0, 3.0}, 0.5, 0.5));
  Lidar3Options options = Exact();
  options.rings = 1;
  options.lowest_beam = options.highest_beam = 0.0;
  const Lidar3 lidar(options, &world);
  int behind = 0;
  int within = 0;
  double depth = 0.0;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const LidarSweep sweep = lidar.Measure([](double) { return At(0.0, 0.0, 1.0); }, 0.0, &random);
    for (const Eigen::Vector3f& point : sweep.points) {
      if (point.x() < 0.0f || std::abs(point.y()) > 0.025f * point.x()) continue;
      if (point.x() > 7.0f) {
        ++behind;
      } else {
        ++within;
        depth += point.x() - 5.5;
        ASSERT_GE(point.x(), 5.5f - 1e-5f);
        ASSERT_LE(point.x(), 6.5f + 1e-5f);
      }
    }
  }
  ASSERT_GT(behind + within, 2000);
  const double share = static_cast<double>(behind) / (behind + within);
  EXPECT_NEAR(share, std::exp(-0.8), 0.03);
  // The mean of an exponential of rate 0.8 below 1.
  EXPECT_NEAR(depth / within, 1.0 / 0.8 - std::exp(-0.8) / (1.0 - std::exp(-0.8)), 0.03);
}

TEST(Lidar3Test, PointsBelongToThePoseOfTheirMoment) {
  World3 world = FlatWorld();
  world.solids.push_back(Frustum::Between({4.0, 1.0, -0.2}, {4.2, 1.1, 2.0}, 0.2, 0.1));
  world.solids.push_back(Frustum::Between({-3.0, -2.0, -0.2}, {-3.0, -2.0, 2.0}, 0.2, 0.1));
  const auto pose_at = [](double time) {
    return At(2.0 * (time - 3.0), 0.3 * (time - 3.0), 0.5 + 0.2 * (time - 3.0), 1.5 * (time - 3.0), 0.5 * (time - 3.0),
              -0.3 * (time - 3.0));
  };
  Random random(1);
  const LidarSweep sweep = Lidar3(Exact(), &world).Measure(pose_at, 3.0, &random);
  int on_solids = 0;
  for (size_t i = 0; i < sweep.points.size(); ++i) {
    const Eigen::Vector3d point = pose_at(3.0 + sweep.times[i]) * sweep.points[i].cast<double>();
    if (std::abs(point.z()) < 1e-4) continue;
    double nearest = kInfinity;
    for (const Frustum& solid : world.solids) {
      const double along = (point - solid.base).dot(solid.axis);
      const double across = (point - solid.base - along * solid.axis).norm();
      nearest = std::min(nearest, std::abs(across - solid.RadiusAt(along)));
    }
    ASSERT_LT(nearest, 1e-4) << i;
    ++on_solids;
  }
  EXPECT_GT(on_solids, 200);
}

TEST(Lidar3Test, MovingSolidsAreWhereTheyAreAtThatMoment) {
  World3 world = FlatWorld();
  const auto post_at = [](double time) {
    const double x = 3.0 + 10.0 * (time - 3.0);
    return Frustum::Between({x, 0.0, -0.2}, {x, 0.0, 2.0}, 0.2, 0.2);
  };
  world.moving = [&](double time) { return std::vector<Frustum>{post_at(time)}; };
  const LidarSweep sweep = MeasureAt(Exact(), world, At(0.0, 0.0, 0.5, 0.0, 0.1, 0.05));
  const Eigen::Isometry3d pose = At(0.0, 0.0, 0.5, 0.0, 0.1, 0.05);
  int hits = 0;
  for (size_t i = 0; i < sweep.points.size(); ++i) {
    const Eigen::Vector3d point = pose * sweep.points[i].cast<double>();
    if (std::abs(point.z()) < 1e-4) continue;
    ++hits;
    const Eigen::Vector2d axis = post_at(3.0 + sweep.times[i]).base.head<2>();
    ASSERT_NEAR((point.head<2>() - axis).norm(), 0.2, 1e-4);
  }
  EXPECT_GT(hits, 100);
}

TEST(Lidar3Test, RangesHaveTheNoiseAndTheStepsAskedFor) {
  World3 world = FlatWorld();
  world.solids.push_back(Frustum::Between({0.0, 0.0, -1.0}, {0.0, 0.0, 20.0}, 9.0, 9.0));
  Lidar3Options options = Exact();
  options.rings = 2;
  options.lowest_beam = 0.0;
  options.highest_beam = 10.0;
  options.range_noise = 0.03;
  options.range_resolution = 0.002;
  options.drop_out = 0.1;
  // From within the hollow drum every beam ends at 9 m / cos(elevation).
  const LidarSweep sweep = MeasureAt(options, world, At(0.0, 0.0, 1.0));
  EXPECT_NEAR(static_cast<double>(sweep.points.size()), 0.9 * 3600.0, 60.0);
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const Eigen::Vector3f& point : sweep.points) {
    const double range = point.cast<double>().norm();
    ASSERT_NEAR(range / 0.002, std::round(range / 0.002), 2e-3);
    const double error = range - (point.z() > 0.5f ? 9.0 / std::cos(DegToRad(10.0)) : 9.0);
    sum += error;
    sum_of_squares += error * error;
  }
  const auto count = static_cast<double>(sweep.points.size());
  EXPECT_NEAR(sum / count, 0.0, 0.003);
  EXPECT_NEAR(std::sqrt(sum_of_squares / count), 0.03, 0.002);
}

TEST(Lidar3Test, SeesNothingTooNearOrTooFar) {
  World3 world = FlatWorld();
  world.solids.push_back(Frustum::Between({0.6, 0.0, -1.0}, {0.6, 0.0, 3.0}, 0.2, 0.2));
  world.solids.push_back(Frustum::Between({-30.0, 0.0, -1.0}, {-30.0, 0.0, 9.0}, 0.5, 0.5));
  Lidar3Options options = Exact();
  options.max_range = 20.0;
  const LidarSweep sweep = MeasureAt(options, world, At(0.0, 0.0, 0.5));
  EXPECT_FALSE(sweep.points.empty());
  for (const Eigen::Vector3f& point : sweep.points) {
    ASSERT_GE(point.norm(), 0.5f - 1e-5f);
    ASSERT_LE(point.norm(), 20.0f + 1e-4f);
  }
  // The post hides the ground behind it although it is too near itself.
  for (const Eigen::Vector3f& point : sweep.points) {
    ASSERT_FALSE(point.x() > 0.9f && std::abs(point.y()) < 0.1f * point.x());
  }
}

TEST(Lidar3Test, FollowsFromTheRandomNumbersGiven) {
  World3 world = FlatWorld();
  Leaves leaves;
  leaves.center = {5.0, 0.0, 1.0};
  world.leaves.push_back(leaves);
  const Lidar3Options options;
  const LidarSweep one = MeasureAt(options, world, At(0.0, 0.0, 0.5), 1);
  const LidarSweep same = MeasureAt(options, world, At(0.0, 0.0, 0.5), 1);
  const LidarSweep other = MeasureAt(options, world, At(0.0, 0.0, 0.5), 2);
  EXPECT_EQ(one.points, same.points);
  EXPECT_EQ(one.times, same.times);
  EXPECT_NE(one.points, other.points);
}

TEST(Lidar3OptionsTest, RefusesWhatCannotBe) {
  EXPECT_EQ(Lidar3Options().Validate(), "");
  EXPECT_EQ(Os1Options().Validate(), "");
  const auto problem = [](auto change) {
    Lidar3Options options;
    change(&options);
    return options.Validate();
  };
  EXPECT_EQ(problem([](Lidar3Options* o) { o->rings = 0; }), "rings is 0, must lie in [1, 256]");
  EXPECT_NE(problem([](Lidar3Options* o) { o->lowest_beam = 90.0; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->highest_beam = -16.0; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->columns = 3; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->first_bearing = 400.0; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->sweep_duration = -1.0; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->sweep_period = 0.05; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->min_range = -1.0; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->max_range = 0.4; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->range_noise = -0.1; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->range_resolution = 2.0; }), "");
  EXPECT_NE(problem([](Lidar3Options* o) { o->drop_out = 1.5; }), "");
}

}  // namespace
}  // namespace arborslam
