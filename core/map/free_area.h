#ifndef ARBORSLAM_CORE_MAP_FREE_AREA_H_
#define ARBORSLAM_CORE_MAP_FREE_AREA_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/map/occupancy_grid.h"

namespace arborslam {

/// Where a map is known to hold nothing, as opposed to where nobody has looked. Immutable.
class FreeArea {
 public:
  /// Free are the cells of `grid` through which more rays passed than met something, if their eight neighbours are
  /// known too: what borders on the unknown counts as unknown, since maps are known to a cell or so only.
  explicit FreeArea(const OccupancyGrid& grid);

  /// True if the cell that `point` [m], in the grid's frame, lies in is free.
  bool Contains(const Eigen::Vector2f& point) const;

  /// Corners [m], in the grid's frame, of a box that holds all that is free.
  const Eigen::Vector2f& low() const { return origin_; }
  /// The same.
  Eigen::Vector2f high() const { return origin_ + Eigen::Vector2f(width_, height_) / inverse_cell_size_; }

 private:
  float inverse_cell_size_;
  Eigen::Vector2f origin_;
  int width_;
  int height_;
  std::vector<uint8_t> is_free_;  // Rows contiguous.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_FREE_AREA_H_
