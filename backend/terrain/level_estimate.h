#ifndef ARBORSLAM_BACKEND_TERRAIN_LEVEL_ESTIMATE_H_
#define ARBORSLAM_BACKEND_TERRAIN_LEVEL_ESTIMATE_H_

#include <vector>

#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "core/io/value_store.h"
#include "frontend/projection/upright_lines.h"

namespace arborslam {

/// The upright lines of one sweep.
struct UprightView {
  SE2 T_map_base;
  Tilt3 tilt;                              ///< The lidar's, over the map: the present estimate.
  Tilt3 tilt_when_seen;                    ///< That with which the lines were measured.
  Stored<std::vector<UprightLine>> lines;  ///< In the base frame.
};

/// How a map leans, as the things that stand upright in it tell.
struct LevelEstimate {
  /// dx/dz and dy/dz in the map's frame of what really is upright; already drawn towards 0 by as much as it is unsure.
  Eigen::Vector2d lean = Eigen::Vector2d::Zero();
  double sigma = 0.0;     ///< [rad], standard deviation of either before that.
  size_t num_places = 0;  ///< Square metres of map that hold an upright line.
};

/// Nothing measures gravity, and the ground may slope from one end of the site to the other; but trunks, posts and
/// walls stand upright on the average. Finds the lean that the lines have in common by robust least squares (Cauchy),
/// together with a taper, by which all things recede upwards wherever they are seen from.
LevelEstimate EstimateLevel(const std::vector<UprightView>& views);

/// `tilt` over `T_map_base` in the map that is turned upright by `level` about its origin. Planar poses stay.
Tilt3 MadeUpright(const Tilt3& tilt, const SE2& T_map_base, const LevelEstimate& level);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_TERRAIN_LEVEL_ESTIMATE_H_
