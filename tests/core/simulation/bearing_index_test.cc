#include "core/simulation/bearing_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(BearingIndexTest, BoundsHoldEveryPointOfAThing) {
  Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Vector3d base(random.Uniform(-5.0, 5.0), random.Uniform(-5.0, 5.0), random.Uniform(-1.0, 1.0));
    const Eigen::Vector3d top =
        base + Eigen::Vector3d(random.Uniform(-2.0, 2.0), random.Uniform(-2.0, 2.0), random.Uniform(0.1, 3.0));
    const Frustum frustum = Frustum::Between(base, top, random.Uniform(0.0, 0.5), random.Uniform(0.0, 0.5));
    const Bounds bounds = BoundsOf(frustum);
    for (int i = 0; i < 50; ++i) {
      const double along = random.Uniform(0.0, frustum.length);
      const Eigen::Vector3d across =
          frustum.axis.cross(Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian())).normalized();
      const Eigen::Vector3d point = frustum.base + along * frustum.axis + frustum.RadiusAt(along) * across;
      ASSERT_LE((point.head<2>() - bounds.center).norm(), bounds.radius + 1e-12);
      ASSERT_GE(point.z(), bounds.low - 1e-12);
      ASSERT_LE(point.z(), bounds.high + 1e-12);
    }
    Leaves leaves;
    leaves.shape = trial % 2 == 0 ? Leaves::Shape::kBox : Leaves::Shape::kEllipsoid;
    leaves.center = base;
    leaves.extent = {random.Uniform(0.1, 2.0), random.Uniform(0.1, 2.0), random.Uniform(0.1, 2.0)};
    leaves.yaw = random.Uniform(-kPi, kPi);
    const Bounds leaf_bounds = BoundsOf(leaves);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d direction =
          Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian()).normalized();
      const Eigen::Vector3d origin = leaves.center - 10.0 * direction;
      const Passage passage = PassageThrough(leaves, origin, direction);
      ASSERT_LT(passage.entry, passage.exit);
      const Eigen::Vector3d point = origin + passage.entry * direction;
      ASSERT_LE((point.head<2>() - leaf_bounds.center).norm(), leaf_bounds.radius + 1e-9);
      ASSERT_GE(point.z(), leaf_bounds.low - 1e-9);
      ASSERT_LE(point.z(), leaf_bounds.high + 1e-9);
    }
  }
}

TEST(BearingIndexTest, NamesEveryThingInABeamsWayNearestFirst) {
  Random random(2);
  int met = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Bounds> things;
    for (int i = 0; i < 60; ++i) {
      things.push_back(
          {{random.Uniform(-25.0, 25.0), random.Uniform(-25.0, 25.0)}, random.Uniform(0.02, 3.0), 0.0, 1.0});
    }
    const Eigen::Vector2d place(random.Uniform(-10.0, 10.0), random.Uniform(-10.0, 10.0));
    constexpr double kMargin = 0.1;
    constexpr double kMaxRange = 20.0;
    const BearingIndex index(things, place, kMargin, kMaxRange);
    for (int beam = 0; beam < 200; ++beam) {
      const double bearing = random.Uniform(-kPi, kPi);
      const Eigen::Vector2d heading(std::cos(bearing), std::sin(bearing));
      const double stray = random.Uniform(0.0, kMargin);
      const double stray_bearing = random.Uniform(-kPi, kPi);
      const Eigen::Vector2d origin = place + stray * Eigen::Vector2d(std::cos(stray_bearing), std::sin(stray_bearing));
      const auto& entries = index.Towards(3.7 * heading);
      ASSERT_TRUE(
          std::is_sorted(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.near < b.near; }));
      for (size_t i = 0; i < things.size(); ++i) {
        const Eigen::Vector2d offset = things[i].center - origin;
        const double along = heading.dot(offset);
        const double across = heading.x() * offset.y() - heading.y() * offset.x();
        const double discriminant = things[i].radius * things[i].radius - across * across;
        if (discriminant <= 0.0) continue;
        const double entry = std::max(0.0, along - std::sqrt(discriminant));
        const double exit = along + std::sqrt(discriminant);
        if (exit <= 0.0 || entry > kMaxRange) continue;
        ++met;
        const auto found = std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.thing == i; });
        ASSERT_NE(found, entries.end()) << trial << " " << beam << " " << i;
        ASSERT_LE(found->near, entry + 1e-5);
        ASSERT_GE(found->far, exit - 1e-5);
      }
    }
  }
  EXPECT_GT(met, 1000);
}

TEST(BearingIndexTest, LeavesOutWhatStandsElsewhere) {
  const std::vector<Bounds> things = {{{5.0, 0.0}, 0.1, 0.0, 1.0},
                                      {{0.0, 5.0}, 0.1, 0.0, 1.0},
                                      {{50.0, 0.0}, 0.1, 0.0, 1.0},
                                      {{-5.0, 1e-3}, 0.1, 0.0, 1.0}};
  const BearingIndex index(things, {0.0, 0.0}, 0.0, 20.0);
  const auto names = [&](const Eigen::Vector2d& heading) {
    std::vector<uint32_t> found;
    for (const auto& entry : index.Towards(heading)) found.push_back(entry.thing);
    return found;
  };
  EXPECT_THAT(names({1.0, 0.0}), testing::ElementsAre(0u));
  EXPECT_THAT(names({0.0, 1.0}), testing::ElementsAre(1u));
  EXPECT_THAT(names({0.0, -1.0}), testing::ElementsAre());
  // On either side of the bearing pi.
  EXPECT_THAT(names({-1.0, 1e-4}), testing::ElementsAre(3u));
  EXPECT_THAT(names({-1.0, -1e-4}), testing::ElementsAre(3u));
}

TEST(BearingIndexTest, SeesAThingItStandsInAllAround) {
  const BearingIndex index({{{0.5, 0.0}, 1.0, 0.0, 1.0}}, {0.0, 0.0}, 0.0, 20.0);
  for (double bearing = -kPi; bearing <= kPi; bearing += 0.01) {
    ASSERT_EQ(index.Towards({std::cos(bearing), std::sin(bearing)}).size(), 1u) << bearing;
  }
}

}  // namespace
}  // namespace arborslam
