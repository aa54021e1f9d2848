#include "core/simulation/planar_corridor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace arborslam {
namespace {

PlanarCorridorOptions Exact() {
  PlanarCorridorOptions options;
  options.lidar.range_noise = 0.0;
  options.lidar.range_resolution = 0.0;
  options.lidar.drop_out = 0.0;
  return options;
}

TEST(PlanarCorridorTest, EveryReturnLiesOnAWall) {
  const PlanarCorridor corridor(Exact());
  const LaserScan scan = corridor.Scan(7);
  int returns = 0;
  for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
    if (!std::isfinite(scan.ranges[beam])) continue;
    ++returns;
    EXPECT_NEAR(std::abs(scan.ranges[beam] * std::sin(scan.Bearing(beam))), 1.5, 1e-4);
  }
  // Beams within asin(1.5 / 30), 7.1 beams, of the x axis see no wall: 15 ahead, and 14 behind, where one slot is
  // empty.
  EXPECT_EQ(returns, 897 - 15 - 14);
}

TEST(PlanarCorridorTest, NothingTellsHowFarAlongItIs) {
  const PlanarCorridor corridor(Exact());
  const LaserScan first = corridor.Scan(0);
  for (const size_t index : {size_t{1}, size_t{50}, corridor.NumScans() - 1}) {
    const LaserScan scan = corridor.Scan(index);
    for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      if (!std::isfinite(first.ranges[beam])) {
        EXPECT_FALSE(std::isfinite(scan.ranges[beam]));
      } else {
        EXPECT_NEAR(scan.ranges[beam], first.ranges[beam], 1e-4);
      }
    }
  }
}

TEST(PlanarCorridorTest, GroundTruthGoesStraightOn) {
  const PlanarCorridor corridor(Exact());
  const Trajectory truth = corridor.GroundTruth();
  ASSERT_EQ(truth.size(), 100u);
  EXPECT_TRUE(truth[0].pose.IsApprox(SE2()));
  EXPECT_TRUE(truth[99].pose.IsApprox(SE2(99 * 0.28, 0.0, 0.0)));
  EXPECT_EQ(truth[99].stamp, corridor.Scan(99).stamp);
}

TEST(PlanarCorridorOptionsTest, ValidateNamesTheKey) {
  EXPECT_EQ(PlanarCorridorOptions().Validate(), "");
  const auto problem = [](auto change) {
    PlanarCorridorOptions options;
    change(&options);
    return options.Validate();
  };
  EXPECT_EQ(problem([](auto* o) { o->width = 0.0; }), "width is 0.0, must lie in (0, 1000]");
  EXPECT_EQ(problem([](auto* o) { o->num_scans = 0; }), "num_scans is 0, must be at least 1");
  EXPECT_NE(problem([](auto* o) { o->roughness = -1.0; }), "");
  EXPECT_NE(problem([](auto* o) { o->lidar.drop_out = 2.0; }), "");
}

}  // namespace
}  // namespace arborslam
