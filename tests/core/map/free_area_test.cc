#include "core/map/free_area.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

OccupancyGridOptions Options() {
  OccupancyGridOptions options;
  options.cell_size = 0.1;
  return options;
}

// A fan of rays ahead, a centimetre apart at their ends on the line x = 3 m; a wall stands there for y > 0.
PlanarScan Fan() {
  PlanarScan scan;
  for (int i = -100; i <= 100; ++i) {
    (i > 0 ? scan.points : scan.free_ends).emplace_back(3.05f, 0.01f * static_cast<float>(i));
  }
  return scan;
}

TEST(FreeAreaTest, IsWhatRaysPassedAndNotWhatBordersOnTheUnknown) {
  OccupancyGrid grid(Options());
  grid.Insert(SE2(0.02, 0.03, 0.0), Fan());
  const FreeArea area(grid);
  EXPECT_TRUE(area.Contains({2.0f, 0.0f}));
  EXPECT_TRUE(area.Contains({2.5f, 0.5f}));
  EXPECT_TRUE(area.Contains({2.95f, 0.5f})) << "behind its neighbour the wall stands, which is known";
  EXPECT_FALSE(area.Contains({3.1f, 0.5f})) << "the wall";
  EXPECT_FALSE(area.Contains({3.3f, 0.5f})) << "behind it";
  EXPECT_FALSE(area.Contains({2.0f, 0.72f})) << "the fan's border, beyond which no ray went";
  EXPECT_FALSE(area.Contains({2.0f, 2.0f}));
  EXPECT_FALSE(area.Contains({-1.0f, 0.0f}));
  EXPECT_FALSE(area.Contains({1000.0f, -1000.0f})) << "outside of the grid";
}

TEST(FreeAreaTest, LiesWithinItsBox) {
  OccupancyGrid grid(Options());
  grid.Insert(SE2(-7.0, 4.0, 1.0), Fan());
  const FreeArea area(grid);
  int num_free = 0;
  for (int x = -200; x < 200; ++x) {
    for (int y = -200; y < 200; ++y) {
      const Eigen::Vector2f point(0.1f * static_cast<float>(x) + 0.05f, 0.1f * static_cast<float>(y) + 0.05f);
      if (!area.Contains(point)) continue;
      ++num_free;
      EXPECT_TRUE((point.array() >= area.low().array()).all() && (point.array() <= area.high().array()).all());
    }
  }
  EXPECT_GT(num_free, 100);
}

TEST(FreeAreaTest, OfNothingIsNothing) {
  const FreeArea area{OccupancyGrid(Options())};
  EXPECT_FALSE(area.Contains({0.0f, 0.0f}));
  EXPECT_TRUE(area.low() == area.high());
}

}  // namespace
}  // namespace arborslam
