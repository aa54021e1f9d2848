#include "core/map/occupied_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

std::vector<OccupiedCell> CellsOfGrid(const std::vector<InsertedScan>& scans, const OccupancyGridOptions& options,
                                      float min_log_odds) {
  OccupancyGrid grid(options);
  for (const InsertedScan& inserted : scans) grid.Insert(inserted.T_grid_base, *inserted.scan);
  return grid.OccupiedCells(min_log_odds);
}

void ExpectSame(const std::vector<OccupiedCell>& cells, const std::vector<OccupiedCell>& expected) {
  ASSERT_EQ(cells.size(), expected.size());
  for (size_t i = 0; i < cells.size(); ++i) {
    EXPECT_NEAR(cells[i].centroid.x(), expected[i].centroid.x(), 1e-5f) << i;
    EXPECT_NEAR(cells[i].centroid.y(), expected[i].centroid.y(), 1e-5f) << i;
    EXPECT_EQ(cells[i].log_odds, expected[i].log_odds) << i;
  }
}

// Scans of places that come and go within a few metres, so that rays pass many cells that were hit, from poses around
// the origin.
std::vector<InsertedScan> RandomScans(int num_scans, bool point_rays_are_free, Random* random) {
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < 120; ++i) places.emplace_back(random->Uniform(-7.0, 7.0), random->Uniform(-7.0, 7.0));
  std::vector<InsertedScan> scans;
  for (int k = 0; k < num_scans; ++k) {
    const SE2 pose(random->Uniform(-2.0, 2.0), random->Uniform(-2.0, 2.0), random->Uniform(-kPi, kPi));
    auto scan = std::make_shared<PlanarScan>();
    scan->point_rays_are_free = point_rays_are_free;
    for (const Eigen::Vector2d& place : places) {
      if (random->Uniform() < 0.3) continue;
      const Eigen::Vector2d noise(0.03 * random->Gaussian(), 0.03 * random->Gaussian());
      scan->points.push_back((pose.Inverse() * Eigen::Vector2d(place + noise)).cast<float>());
    }
    for (int i = 0; i < 90; ++i) {
      const double bearing = random->Uniform(-kPi, kPi);
      const double range = random->Uniform(0.0, 9.0);
      scan->free_ends.emplace_back(range * std::cos(bearing), range * std::sin(bearing));
    }
    scans.push_back({pose, scan});
  }
  return scans;
}

TEST(OccupiedCellsTest, AreThoseOfTheGrid) {
  Random random(11);
  size_t num_cells = 0;
  size_t num_hit = 0;
  for (int trial = 0; trial < 40; ++trial) {
    OccupancyGridOptions options;
    options.cell_size = random.Uniform(0.02, 0.3);
    options.miss_range = random.Uniform(0.0, 10.0);
    const std::vector<InsertedScan> scans = RandomScans(1 + trial % 20, trial % 2 == 0, &random);
    const std::vector<OccupiedCell> cells = OccupiedCellsOf(scans, options, 0.5f);
    ExpectSame(cells, CellsOfGrid(scans, options, 0.5f));
    const std::vector<OccupiedCell> all = OccupiedCellsOf(scans, options, -100.0f);
    ExpectSame(all, CellsOfGrid(scans, options, -100.0f));
    num_cells += cells.size();
    num_hit += all.size();
  }
  // Rays did take cells away.
  EXPECT_LT(num_cells, num_hit);
  EXPECT_GT(num_cells, 0u);
}

TEST(OccupiedCellsTest, RaysAlongTheAxesFromWithinACell) {
  auto scan = std::make_shared<PlanarScan>();
  scan->points = {{2.0f, 0.0f}, {0.0f, 2.0f}, {-2.0f, 0.0f}, {0.0f, -2.0f}};
  auto near = std::make_shared<PlanarScan>();
  near->points = {{1.0f, 0.0f}, {0.0f, 1.0f}, {-1.0f, 0.0f}, {0.0f, -1.0f}, {0.001f, 0.001f}};
  const SE2 pose(0.025, 0.025, 0.0);
  const std::vector<InsertedScan> scans = {{pose, near}, {pose, scan}, {pose, scan}, {pose, scan}, {pose, scan}};
  ExpectSame(OccupiedCellsOf(scans, OccupancyGridOptions(), -100.0f),
             CellsOfGrid(scans, OccupancyGridOptions(), -100.0f));
  EXPECT_EQ(OccupiedCellsOf(scans, OccupancyGridOptions(), 0.0f).size(), 4u);
}

TEST(OccupiedCellsTest, NothingGivesNothing) {
  EXPECT_TRUE(OccupiedCellsOf({}, OccupancyGridOptions(), -100.0f).empty());
  auto empty = std::make_shared<PlanarScan>();
  EXPECT_TRUE(OccupiedCellsOf({{SE2(), empty}}, OccupancyGridOptions(), -100.0f).empty());
  // A return from the lidar itself has no ray.
  auto at_base = std::make_shared<PlanarScan>();
  at_base->points = {{0.0f, 0.0f}};
  EXPECT_EQ(OccupiedCellsOf({{SE2(0.01, 0.01, 0.0), at_base}}, OccupancyGridOptions(), -100.0f).size(), 1u);
}

}  // namespace
}  // namespace arborslam
