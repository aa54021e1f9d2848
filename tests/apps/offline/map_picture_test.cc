#include "apps/offline/map_picture.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

// 4 x 3 cells of 0.5 m at (10, 20): free, but for an occupied cell at the lower right and an unknown one above it.
GridImage SmallMap() {
  GridImage map;
  map.width = 4;
  map.height = 3;
  map.resolution = 0.5;
  map.origin_x = 10.0;
  map.origin_y = 20.0;
  map.occupancy.assign(12, 0);
  map.occupancy[3] = 100;
  map.occupancy[7] = GridImage::kUnknown;
  return map;
}

TEST(DrawBackdropTest, OnePixelACellTopRowFirst) {
  const MapBackdrop backdrop = DrawBackdrop(SmallMap(), 100);
  EXPECT_EQ(backdrop.image.width, 4);
  EXPECT_EQ(backdrop.image.height, 3);
  EXPECT_EQ(backdrop.image.pixels,
            (std::vector<uint8_t>{255, 255, 255, 255, 255, 255, 255, kUnknownShade, 255, 255, 255, 0}));
  EXPECT_DOUBLE_EQ(backdrop.metres_per_pixel, 0.5);
  EXPECT_DOUBLE_EQ(backdrop.left, 10.0);
  EXPECT_DOUBLE_EQ(backdrop.top, 21.5);
}

TEST(DrawBackdropTest, AReducedMapKeepsWhatIsOccupied) {
  GridImage map = SmallMap();
  map.width = 401;
  map.height = 100;
  map.occupancy.assign(40100, 0);
  map.occupancy[50 * 401 + 200] = 100;
  const MapBackdrop backdrop = DrawBackdrop(map, 50);
  EXPECT_EQ(backdrop.image.width, 50);
  EXPECT_NEAR(backdrop.metres_per_pixel, 0.5 * 401 / 50, 1e-9);
  EXPECT_NEAR(backdrop.top - backdrop.image.height * backdrop.metres_per_pixel, 20.0, 1e-9);
  // The pixel that holds the middle of that cell.
  const auto column = static_cast<size_t>(200.5 * 0.5 / backdrop.metres_per_pixel);
  const auto row = static_cast<size_t>((backdrop.top - 20.0 - 50.5 * 0.5) / backdrop.metres_per_pixel);
  EXPECT_EQ(backdrop.image.pixels.at(row * 50 + column), 0);
  EXPECT_EQ(backdrop.image.pixels.at(0), 255);
}

}  // namespace
}  // namespace arborslam
