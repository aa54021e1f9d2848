#include "core/map/free_area.h"

#include <cmath>
#include <cstddef>

namespace arborslam {

FreeArea::FreeArea(const OccupancyGrid& grid)
    : inverse_cell_size_(static_cast<float>(1.0 / grid.cell_size())),
      origin_(grid.origin().cast<float>()),
      width_(grid.width()),
      height_(grid.height()),
      is_free_(static_cast<size_t>(width_) * static_cast<size_t>(height_), 0) {
  const auto are_neighbours_known = [&grid](int x, int y) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!grid.IsKnown(x + dx, y + dy)) return false;
      }
    }
    return true;
  };
  for (int y = 1; y + 1 < height_; ++y) {
    uint8_t* row = is_free_.data() + static_cast<ptrdiff_t>(y) * width_;
    for (int x = 1; x + 1 < width_; ++x) row[x] = grid.LogOdds(x, y) < 0.0f && are_neighbours_known(x, y) ? 1 : 0;
  }
}

bool FreeArea::Contains(const Eigen::Vector2f& point) const {
  const Eigen::Vector2f cell = inverse_cell_size_ * (point - origin_);
  const int x = static_cast<int>(std::floor(cell.x()));
  const int y = static_cast<int>(std::floor(cell.y()));
  return x >= 0 && y >= 0 && x < width_ && y < height_ &&
         is_free_[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)] != 0;
}

}  // namespace arborslam
