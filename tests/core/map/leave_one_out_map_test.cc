#include "core/map/leave_one_out_map.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

// Random scans of a small place, so that they hit and pass the same cells again and again.
struct RandomScans {
  explicit RandomScans(Random* random) {
    for (int i = 0; i < 12; ++i) {
      const double x = random->Uniform(-2.0, 2.0);
      const double y = random->Uniform(-2.0, 2.0);
      poses.emplace_back(x, y, random->Uniform(-kPi, kPi));
      auto scan = std::make_shared<PlanarScan>();
      scan->point_rays_are_free = i % 2 == 0;
      for (int j = 0; j < 80; ++j) {
        const auto end_x = static_cast<float>(random->Uniform(-5.0, 5.0));
        const auto end_y = static_cast<float>(random->Uniform(-5.0, 5.0));
        (j % 3 == 0 ? scan->free_ends : scan->points).emplace_back(end_x, end_y);
      }
      scans.push_back(scan);
    }
  }

  std::vector<SE2> poses;
  std::vector<std::shared_ptr<const PlanarScan>> scans;
};

TEST(LeaveOneOutMapTest, IsTheGridBuiltWithoutTheScan) {
  Random random(4);
  for (const double cell_size : {0.1, 0.5}) {
    OccupancyGridOptions options;
    options.cell_size = cell_size;
    const RandomScans world(&random);
    const LeaveOneOutMap map(options, world.poses, world.scans);
    for (size_t left_out = 0; left_out < world.scans.size(); ++left_out) {
      OccupancyGrid grid(options);
      for (size_t i = 0; i < world.scans.size(); ++i) {
        if (i != left_out) grid.Insert(world.poses[i], *world.scans[i]);
      }
      for (const float min_log_odds : {-std::numeric_limits<float>::infinity(), 0.2f}) {
        SCOPED_TRACE("without scan " + std::to_string(left_out) + ", cells of " + std::to_string(cell_size) + " m");
        const std::vector<OccupiedCell> expected = grid.OccupiedCells(min_log_odds);
        const std::vector<OccupiedCell> cells = map.OccupiedCellsWithout(left_out, min_log_odds);
        ASSERT_GT(expected.size(), 50u);
        ASSERT_EQ(cells.size(), expected.size());
        for (size_t i = 0; i < cells.size(); ++i) {
          EXPECT_EQ(cells[i].centroid, expected[i].centroid);
          EXPECT_EQ(cells[i].log_odds, expected[i].log_odds);
        }
      }
    }
  }
}

TEST(LeaveOneOutMapTest, NothingIsLeftOfTheOnlyScan) {
  auto scan = std::make_shared<PlanarScan>();
  scan->points = {{1.0f, 0.0f}};
  const LeaveOneOutMap map(OccupancyGridOptions(), {SE2()}, {scan});
  EXPECT_TRUE(map.OccupiedCellsWithout(0, -std::numeric_limits<float>::infinity()).empty());
}

}  // namespace
}  // namespace arborslam
