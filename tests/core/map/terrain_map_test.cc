#include "core/map/terrain_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(TerrainMap, KnowsNothingAtFirst) {
  const TerrainMap terrain(1.0);
  EXPECT_FALSE(terrain.At({0.0, 0.0}).has_value());
}

TEST(TerrainMap, OneSampleIsALevelNearby) {
  TerrainMap terrain(1.0);
  terrain.Insert({-3.5, 2.5, 0.7}, 1.0);
  const auto surface = terrain.At({-3.2, 2.4});
  ASSERT_TRUE(surface.has_value());
  EXPECT_NEAR(surface->z, 0.7, 1e-9);
  EXPECT_NEAR(surface->slope.norm(), 0.0, 1e-9);
  EXPECT_FALSE(terrain.At({-1.0, 2.5}).has_value());
  EXPECT_EQ(terrain.num_cells(), 1u);
}

TEST(TerrainMap, FollowsASlope) {
  TerrainMap terrain(1.0);
  Random random(3);
  const auto plane = [](double x, double y) { return 0.4 + 0.2 * x - 0.1 * y; };
  for (int i = 0; i < 20000; ++i) {
    const double x = random.Uniform(-8.0, 8.0);
    const double y = random.Uniform(-8.0, 8.0);
    terrain.Insert({x, y, plane(x, y)}, 1.0);
  }
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d position(random.Uniform(-6.0, 6.0), random.Uniform(-6.0, 6.0));
    const auto surface = terrain.At(position);
    ASSERT_TRUE(surface.has_value());
    EXPECT_NEAR(surface->z, plane(position.x(), position.y()), 0.02);
    EXPECT_NEAR(surface->slope.x(), 0.2, 0.03);
    EXPECT_NEAR(surface->slope.y(), -0.1, 0.03);
  }
}

TEST(TerrainMap, WorksFarFromTheOriginAndAcrossIt) {
  for (const double shift : {-1e6, -0.5, 0.5, 1e6}) {
    TerrainMap terrain(0.5);
    terrain.Insert({shift, shift, 1.0}, 2.0);
    terrain.Insert({shift, shift, 4.0}, 1.0);
    EXPECT_NEAR(terrain.At({shift, shift})->z, 2.0, 1e-6);
  }
}

}  // namespace
}  // namespace arborslam
