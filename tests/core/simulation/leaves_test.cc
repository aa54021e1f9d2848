#include "core/simulation/leaves.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(LeavesTest, BeamPassesASphereBetweenItsTwoSides) {
  Leaves leaves;
  leaves.center = {10.0, 0.0, 1.0};
  leaves.extent = {2.0, 2.0, 2.0};
  const Passage middle = PassageThrough(leaves, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0});
  EXPECT_DOUBLE_EQ(middle.entry, 8.0);
  EXPECT_DOUBLE_EQ(middle.exit, 12.0);
  const Passage aside = PassageThrough(leaves, {0.0, 1.2, 1.0}, {1.0, 0.0, 0.0});
  EXPECT_NEAR(aside.entry, 8.4, 1e-12);
  EXPECT_NEAR(aside.exit, 11.6, 1e-12);
  const Passage from_within = PassageThrough(leaves, {10.0, 0.0, 1.0}, {0.0, 0.0, 1.0});
  EXPECT_EQ(from_within.entry, 0.0);
  EXPECT_DOUBLE_EQ(from_within.exit, 2.0);
  const Passage missed = PassageThrough(leaves, {0.0, 2.1, 1.0}, {1.0, 0.0, 0.0});
  EXPECT_GE(missed.entry, missed.exit);
  const Passage behind = PassageThrough(leaves, {20.0, 0.0, 1.0}, {1.0, 0.0, 0.0});
  EXPECT_GE(behind.entry, behind.exit);
}

TEST(LeavesTest, BoxIsTurnedByItsYaw) {
  Leaves leaves;
  leaves.shape = Leaves::Shape::kBox;
  leaves.extent = {4.0, 0.5, 1.0};
  const Passage across = PassageThrough(leaves, {3.0, -5.0, 0.0}, {0.0, 1.0, 0.0});
  EXPECT_DOUBLE_EQ(across.entry, 4.5);
  EXPECT_DOUBLE_EQ(across.exit, 5.5);
  leaves.yaw = kPi / 2.0;
  const Passage along = PassageThrough(leaves, {0.2, -5.0, 0.0}, {0.0, 1.0, 0.0});
  EXPECT_NEAR(along.entry, 1.0, 1e-12);
  EXPECT_NEAR(along.exit, 9.0, 1e-12);
  const Passage missed = PassageThrough(leaves, {3.0, -5.0, 0.0}, {0.0, 1.0, 0.0});
  EXPECT_GE(missed.entry, missed.exit);
}

bool IsInside(const Leaves& leaves, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = Eigen::AngleAxisd(-leaves.yaw, Eigen::Vector3d::UnitZ()) * (point - leaves.center);
  const Eigen::Vector3d scaled = offset.cwiseQuotient(leaves.extent);
  return leaves.shape == Leaves::Shape::kBox ? scaled.cwiseAbs().maxCoeff() <= 1.0 : scaled.norm() <= 1.0;
}

TEST(LeavesTest, PassageAgreesWithBruteForceSampling) {
  Random random(4);
  int hits = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    Leaves leaves;
    leaves.shape = trial % 2 == 0 ? Leaves::Shape::kBox : Leaves::Shape::kEllipsoid;
    leaves.center = {random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0)};
    leaves.extent = {random.Uniform(0.1, 2.0), random.Uniform(0.1, 2.0), random.Uniform(0.1, 2.0)};
    leaves.yaw = random.Uniform(-kPi, kPi);
    const Eigen::Vector3d origin(random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0));
    const Eigen::Vector3d aim =
        leaves.center + Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
    const Eigen::Vector3d direction = (aim - origin).normalized();
    const Passage passage = PassageThrough(leaves, origin, direction);
    hits += passage.entry < passage.exit ? 1 : 0;
    for (double range = 0.0; range < 12.0; range += 0.02) {
      const bool is_well_within = range > passage.entry + 1e-9 && range < passage.exit - 1e-9;
      const bool is_well_without = range < passage.entry - 1e-9 || range > passage.exit + 1e-9;
      const bool is_inside = IsInside(leaves, origin + range * direction);
      if (is_well_within) {
        ASSERT_TRUE(is_inside) << trial << " " << range;
      } else if (is_well_without || passage.entry >= passage.exit) {
        ASSERT_FALSE(is_inside) << trial << " " << range;
      }
    }
  }
  EXPECT_GT(hits, 100);
}

}  // namespace
}  // namespace arborslam
