#ifndef ARBORSLAM_CORE_MAP_OCCUPIED_CELLS_H_
#define ARBORSLAM_CORE_MAP_OCCUPIED_CELLS_H_

#include <memory>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/occupancy_grid.h"
#include "core/sensor/planar_scan.h"

namespace arborslam {

/// A scan as it goes into a map.
struct InsertedScan {
  SE2 T_grid_base;
  std::shared_ptr<const PlanarScan> scan;
};

/// The `OccupancyGrid::OccupiedCells(min_log_odds)` of a grid that all of `scans` are inserted into in their order, but
/// several times as fast: only cells that were hit count, so it is asked of these which rays pass them, instead of
/// following all rays through cells that nothing stands in. (Where a ray meets the corner of a cell to within rounding,
/// the two may differ.)
std::vector<OccupiedCell> OccupiedCellsOf(const std::vector<InsertedScan>& scans, const OccupancyGridOptions& options,
                                          float min_log_odds);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_OCCUPIED_CELLS_H_
