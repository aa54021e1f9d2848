#include "core/simulation/footprint_map.h"

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

constexpr double kHeight = 1.0;  // [m] above the ground.

// Occupies the cells that touch the disc.
void DrawDisc(const Eigen::Vector2d& center, double radius, GridImage* map) {
  const double x = (center.x() - map->origin_x) / map->resolution;
  const double y = (center.y() - map->origin_y) / map->resolution;
  const double reach = radius / map->resolution;
  const int first_row = std::max(0, static_cast<int>(std::floor(y - reach)));
  const int last_row = std::min(map->height - 1, static_cast<int>(std::floor(y + reach)));
  const int first_column = std::max(0, static_cast<int>(std::floor(x - reach)));
  const int last_column = std::min(map->width - 1, static_cast<int>(std::floor(x + reach)));
  for (int row = first_row; row <= last_row; ++row) {
    for (int column = first_column; column <= last_column; ++column) {
      const double dx = std::clamp<double>(x, column, column + 1) - x;
      const double dy = std::clamp<double>(y, row, row + 1) - y;
      if (dx * dx + dy * dy > reach * reach) continue;
      map->occupancy[static_cast<size_t>(row) * static_cast<size_t>(map->width) + static_cast<size_t>(column)] = 100;
    }
  }
}

}  // namespace

GridImage FootprintMap(const World3& world, const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                       double resolution) {
  GridImage map;
  map.resolution = resolution;
  const auto first_x = static_cast<int>(std::floor(low.x() / resolution));
  const auto first_y = static_cast<int>(std::floor(low.y() / resolution));
  map.origin_x = first_x * resolution;
  map.origin_y = first_y * resolution;
  map.width = std::max(1, static_cast<int>(std::ceil(high.x() / resolution)) - first_x);
  map.height = std::max(1, static_cast<int>(std::ceil(high.y() / resolution)) - first_y);
  map.occupancy.assign(static_cast<size_t>(map.width) * static_cast<size_t>(map.height), 0);
  for (const Frustum& solid : world.solids) {
    const double rise = solid.axis.z();
    if (rise <= 0.0) continue;
    const double ground = world.terrain.Height(solid.base.head<2>());
    const double begin = std::max(0.0, (ground - solid.base.z()) / rise);
    const double end = std::min(solid.length, (ground + kHeight - solid.base.z()) / rise);
    const int steps = 1 + static_cast<int>(std::ceil(std::max(0.0, end - begin) / resolution));
    for (int i = 0; i <= steps && begin <= end; ++i) {
      const double along = begin + (end - begin) * i / steps;
      DrawDisc((solid.base + along * solid.axis).head<2>(), solid.RadiusAt(along), &map);
    }
  }
  return map;
}

}  // namespace arborslam
