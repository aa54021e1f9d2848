#ifndef ARBORSLAM_TESTS_FRONTEND_SIMULATED_RUN_H_
#define ARBORSLAM_TESTS_FRONTEND_SIMULATED_RUN_H_

#include <vector>

#include "core/map/occupancy_grid.h"
#include "core/simulation/planar_orchard.h"
#include "frontend/matching/match_target.h"
#include "frontend/projection/laser_projection.h"

namespace arborslam {

constexpr double kTestMaxDistance = 0.2;  // [m], D_max.

/// A grid of default options' occupied cells as a target.
inline MatchTarget TargetOf(const OccupancyGrid& grid) {
  return MatchTarget(grid.OccupiedCells(static_cast<float>(LogOddsOf(0.55))), grid.cell_size(), kTestMaxDistance);
}

/// The map of `count` scans of `world` from `first` on, at their true poses, without `left_out`.
template <class World>
OccupancyGrid MapOf(const World& world, size_t first, size_t count, size_t left_out = static_cast<size_t>(-1)) {
  OccupancyGrid grid{OccupancyGridOptions()};
  for (size_t i = first; i < first + count; ++i) {
    if (i != left_out) grid.Insert(world.TruePose(i), ProjectLaserScan(world.Scan(i), ProjectionOptions()));
  }
  return grid;
}

/// A scan's points by the default projection.
template <class World>
std::vector<Eigen::Vector2f> PointsOf(const World& world, size_t index) {
  return ProjectLaserScan(world.Scan(index), ProjectionOptions()).points;
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_FRONTEND_SIMULATED_RUN_H_
