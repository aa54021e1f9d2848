#ifndef ARBORSLAM_APPS_OFFLINE_MAP_PICTURE_H_
#define ARBORSLAM_APPS_OFFLINE_MAP_PICTURE_H_

#include <vector>

#include "core/io/map_io.h"
#include "core/io/png.h"
#include "core/map/occupancy_grid.h"
#include "core/sensor/stamped_pose.h"

namespace arborslam {

/// The known part of `grid` for exchange, with a margin of one cell.
GridImage ToGridImage(const OccupancyGrid& grid);

/// A picture of the map: white is free, grey unknown, black occupied, each trajectory from a green start to a red end,
/// the first one blue, others in colours of their own. A map that is too large is drawn at a fraction of its
/// resolution.
RgbImage DrawMap(const GridImage& map, const std::vector<Trajectory>& trajectories);

/// The map alone, and where it lies.
struct MapBackdrop {
  GreyImage image;                ///< White is free, grey (`kUnknownShade`) unknown, black occupied; 16 shades.
  double metres_per_pixel = 1.0;  ///< [m]
  double left = 0.0;              ///< [m], x of the image's left edge.
  double top = 0.0;               ///< [m], y of its top edge.
};
constexpr uint8_t kUnknownShade = 221;

/// Draws `map` at its own resolution, or at a fraction of it so that no side exceeds `max_side` [pixels].
MapBackdrop DrawBackdrop(const GridImage& map, int max_side);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_MAP_PICTURE_H_
