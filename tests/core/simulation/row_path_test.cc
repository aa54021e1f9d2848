#include "core/simulation/row_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

TEST(RowPathTest, GoesUpAndDownTheLanesAndBackToTheStart) {
  const ClosedPath path = RowPath({0, 1, 2, 3}, 4.0, -2.0, 20.0, 0.5);
  // Sharp corners: four lanes of 22 m and headlands of 3 x 4 m and 12 m.
  EXPECT_NEAR(path.Length(), 112.0, 8 * 0.5 * (2.0 - 1.5707));
  EXPECT_TRUE(path.At(0.0).IsApprox(SE2(), 1e-9));
  double lowest = 1e9;
  double highest = -1e9;
  int in_lane_two = 0;
  for (double distance = 0.0; distance < path.Length(); distance += 0.5) {
    const SE2 place = path.At(distance);
    lowest = std::min(lowest, place.y());
    highest = std::max(highest, place.y());
    ASSERT_GE(place.x(), -2.0 - 1e-9);
    ASSERT_LE(place.x(), 20.0 + 1e-9);
    const bool is_turning = place.x() < -1.4 || place.x() > 19.4;
    if (is_turning) continue;
    // In a lane, eastwards in the even ones.
    const double lane = place.y() / 4.0;
    ASSERT_NEAR(lane, std::round(lane), 1e-9);
    ASSERT_NEAR(std::cos(place.theta()), std::lround(lane) % 2 == 0 ? 1.0 : -1.0, 1e-9);
    in_lane_two += std::lround(lane) == 2 ? 1 : 0;
  }
  EXPECT_NEAR(lowest, 0.0, 1e-9);
  EXPECT_NEAR(highest, 12.0, 1e-9);
  EXPECT_NEAR(in_lane_two, 42, 2);
}

}  // namespace
}  // namespace arborslam
