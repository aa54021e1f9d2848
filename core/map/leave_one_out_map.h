#ifndef ARBORSLAM_CORE_MAP_LEAVE_ONE_OUT_MAP_H_
#define ARBORSLAM_CORE_MAP_LEAVE_ONE_OUT_MAP_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/occupancy_grid.h"
#include "core/map/passed_cells.h"
#include "core/sensor/planar_scan.h"

namespace arborslam {

/// What an occupancy grid of many scans would be without any one of them. Rays are cast once; to leave a scan out only
/// the evidence of those cells that it touched is gone through again.
class LeaveOneOutMap {
 public:
  /// @param T_grid_base where the scans were taken, in the order of their insertion.
  /// @param scans       as many, none of them null.
  LeaveOneOutMap(const OccupancyGridOptions& options, const std::vector<SE2>& T_grid_base,
                 const std::vector<std::shared_ptr<const PlanarScan>>& scans);

  /// `OccupancyGrid::OccupiedCells` of a grid that all scans were inserted into but number `left_out`.
  std::vector<OccupiedCell> OccupiedCellsWithout(size_t left_out, float min_log_odds) const;

 private:
  struct Hit {
    size_t scan;
    size_t order;            // Among all hits.
    Eigen::Vector2f offset;  // [m], from the cell's corner.
  };
  struct Cell {
    int64_t x;  // Of the plane.
    int64_t y;
    std::vector<Hit> hits;
    OccupiedCell with_all{Eigen::Vector2f::Zero(), 0.0f};
  };

  // What all scans but `left_out` say of a cell that one of them hit.
  OccupiedCell Replay(const Cell& cell, std::optional<size_t> left_out) const;

  OccupancyGridOptions options_;
  std::vector<PassedCells> passed_;  // Of each scan.
  std::vector<Cell> cells_;          // That were ever hit, in the order of their first hits.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_LEAVE_ONE_OUT_MAP_H_
