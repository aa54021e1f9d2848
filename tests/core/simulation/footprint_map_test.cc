#include "core/simulation/footprint_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

World3 FlatWorld() {
  UnevenGroundOptions options;
  options.undulation = 0.0;
  options.bumps = 0.0;
  options.grass_height = 0.0;
  return {UnevenGround(options, 1, {-20.0, -20.0}, {20.0, 20.0}), {}, {}, {}};
}

// Whether the square of the cell touches a disc.
bool Touches(const GridImage& map, int column, int row, const Eigen::Vector2d& center, double radius) {
  double nearest = 1e9;
  constexpr int kSamples = 20;
  for (int i = 0; i <= kSamples; ++i) {
    for (int j = 0; j <= kSamples; ++j) {
      const double x = map.origin_x + map.resolution * (column + static_cast<double>(i) / kSamples);
      const double y = map.origin_y + map.resolution * (row + static_cast<double>(j) / kSamples);
      nearest = std::min(nearest, (Eigen::Vector2d(x, y) - center).norm());
    }
  }
  return nearest <= radius;
}

TEST(FootprintMapTest, AConeOccupiesTheDiscOfItsBase) {
  World3 world = FlatWorld();
  const Eigen::Vector3d base(0.503, -0.207, 0.0);
  world.solids.push_back(Frustum::Between(base, base + Eigen::Vector3d(0.0, 0.0, 0.5), 0.2, 0.02));
  world.leaves.push_back(Leaves());
  const GridImage map = FootprintMap(world, {-1.003, -1.5}, {2.0, 1.001}, 0.05);
  EXPECT_NEAR(map.origin_x, -1.05, 1e-12);
  EXPECT_NEAR(map.origin_y, -1.5, 1e-12);
  EXPECT_EQ(map.width, 61);
  EXPECT_EQ(map.height, 51);
  ASSERT_EQ(map.occupancy.size(), 61u * 51u);
  int occupied = 0;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      const uint8_t cell = map.occupancy[static_cast<size_t>(row) * 61u + static_cast<size_t>(column)];
      const bool is_surely_in = Touches(map, column, row, base.head<2>(), 0.2 - 0.001);
      const bool is_surely_out = !Touches(map, column, row, base.head<2>(), 0.2 + 0.003);
      if (is_surely_in) {
        ASSERT_EQ(cell, 100) << row << " " << column;
      } else if (is_surely_out) {
        ASSERT_EQ(cell, 0) << row << " " << column;
      }
      occupied += cell == 100 ? 1 : 0;
    }
  }
  EXPECT_GT(occupied, 50);
}

TEST(FootprintMapTest, ALeaningTrunkLeavesItsTrailUpToAMetre) {
  World3 world = FlatWorld();
  // Leans 45 deg towards +x; from half a metre underground.
  world.solids.push_back(Frustum::Between({-0.5, 0.0, -0.5}, {3.0, 0.0, 3.0}, 0.1, 0.1));
  const GridImage map = FootprintMap(world, {-2.0, -1.0}, {4.0, 1.0}, 0.05);
  int first = map.width;
  int last = -1;
  for (int column = 0; column < map.width; ++column) {
    for (int row = 0; row < map.height; ++row) {
      if (map.occupancy[static_cast<size_t>(row * map.width + column)] != 100) continue;
      first = std::min(first, column);
      last = std::max(last, column);
      const double y = map.origin_y + map.resolution * (row + 0.5);
      EXPECT_LT(std::abs(y), 0.1 + 0.05);
    }
  }
  EXPECT_NEAR(map.origin_x + map.resolution * first, -0.1, 0.051);
  EXPECT_NEAR(map.origin_x + map.resolution * (last + 1), 1.1, 0.051);
}

TEST(FootprintMapTest, WhatIsAboveAMetreOrOutsideLeavesNoTrace) {
  World3 world = FlatWorld();
  world.solids.push_back(Frustum::Between({0.0, 0.0, 1.2}, {0.5, 0.0, 2.0}, 0.1, 0.1));
  world.solids.push_back(Frustum::Between({5.0, 0.0, 0.0}, {5.0, 0.0, 2.0}, 0.1, 0.1));
  const GridImage map = FootprintMap(world, {-1.0, -1.0}, {1.0, 1.0}, 0.05);
  EXPECT_EQ(*std::max_element(map.occupancy.begin(), map.occupancy.end()), 0);
}

}  // namespace
}  // namespace arborslam
