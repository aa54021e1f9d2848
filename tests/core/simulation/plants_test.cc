#include "core/simulation/plants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

World3 WavyWorld() {
  UnevenGroundOptions options;
  options.undulation = 0.4;
  return {UnevenGround(options, 1, {-50.0, -50.0}, {50.0, 50.0}), {}, {}, {}};
}

TEST(PlantsTest, TreesStandInTheGroundAndTheirLimbsAboveAMetre) {
  World3 world = WavyWorld();
  Random random(1);
  TreeShape shape;
  shape.crown_base = 0.4;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d place(random.Uniform(-40.0, 40.0), random.Uniform(-40.0, 40.0));
    world.solids.clear();
    world.leaves.clear();
    PlantTree(place, shape, &random, &world);
    ASSERT_EQ(world.solids.size(), 4u);
    ASSERT_EQ(world.leaves.size(), 3u);
    const double ground = world.terrain.Height(place);
    const Frustum& trunk = world.solids[0];
    // Where the trunk comes out of the ground is the place, and there it has the radius of its kind.
    const double depth = (ground - trunk.base.z()) / trunk.axis.z();
    ASSERT_GT(depth, 0.2);
    ASSERT_LT(((trunk.base + depth * trunk.axis).head<2>() - place).norm(), 1e-9);
    ASSERT_NEAR(trunk.RadiusAt(depth), shape.trunk_radius, 0.25 * shape.trunk_radius + 1e-9);
    ASSERT_LT(trunk.top_radius, trunk.RadiusAt(depth));
    ASSERT_GT(trunk.axis.z(), std::cos(DegToRad(18.0)));
    for (size_t limb = 1; limb < 4; ++limb) {
      ASSERT_GT(world.solids[limb].base.z(), ground + 0.9);
      ASSERT_GT(world.solids[limb].axis.z(), 0.0);
    }
    for (const Leaves& leaves : world.leaves) {
      ASSERT_GT(leaves.center.z() - leaves.extent.z(), ground);
      ASSERT_LT((leaves.center.head<2>() - place).norm(), shape.crown_radius);
      ASSERT_GT(leaves.density, 0.0);
    }
  }
}

TEST(PlantsTest, FencePostsStandEvenly) {
  World3 world = WavyWorld();
  Random random(1);
  SetFence({-10.0, 3.0}, {20.0, 3.0}, 2.9, &random, &world);
  ASSERT_EQ(world.solids.size(), 10u);
  for (size_t i = 0; i < world.solids.size(); ++i) {
    EXPECT_NEAR(world.solids[i].base.x(), -10.0 + 3.0 * static_cast<double>(i), 0.15);
    EXPECT_NEAR(world.solids[i].base.y(), 3.0, 0.15);
  }
}

TEST(PlantsTest, LeafWallsRunFromEndToEndWithTheirGaps) {
  World3 world = WavyWorld();
  Random random(1);
  LeafWallShape shape;
  shape.gaps = 0.3;
  PlantLeafWall({0.0, 0.0}, {0.0, 40.0}, shape, &random, &world);
  EXPECT_NEAR(static_cast<double>(world.leaves.size()), 28.0, 9.0);
  for (const Leaves& leaves : world.leaves) {
    EXPECT_EQ(leaves.shape, Leaves::Shape::kBox);
    EXPECT_LT(std::abs(leaves.center.x()), 0.3);
    EXPECT_NEAR(leaves.yaw, kPi / 2.0, 0.25);
    const double ground = world.terrain.SmoothHeight(leaves.center.head<2>());
    EXPECT_NEAR(leaves.center.z() - leaves.extent.z() - ground, shape.bottom, 0.15);
    EXPECT_NEAR(leaves.center.z() + leaves.extent.z() - ground, shape.top, 0.25);
  }
  const size_t with_gaps = world.leaves.size();
  shape.gaps = 0.0;
  PlantLeafWall({10.0, 0.0}, {10.0, 40.0}, shape, &random, &world);
  EXPECT_EQ(world.leaves.size() - with_gaps, 40u);
}

TEST(PlantsTest, BushesAndPostsStandOnTheGround) {
  World3 world = WavyWorld();
  Random random(1);
  PlantBush({4.0, 5.0}, 0.5, 1.0, 2.0, &world);
  const double ground = world.terrain.Height({4.0, 5.0});
  ASSERT_EQ(world.leaves.size(), 1u);
  EXPECT_NEAR(world.leaves[0].center.z() + world.leaves[0].extent.z(), ground + 1.0, 1e-9);
  EXPECT_LT(world.leaves[0].center.z() - world.leaves[0].extent.z(), ground);
  SetPost({4.0, 5.0}, 0.05, 1.5, 0.0, &random, &world);
  ASSERT_EQ(world.solids.size(), 1u);
  EXPECT_NEAR((world.solids[0].base + world.solids[0].length * world.solids[0].axis).z(), ground + 1.5, 1e-9);
  EXPECT_LT(world.solids[0].base.z(), ground);
}

}  // namespace
}  // namespace arborslam
