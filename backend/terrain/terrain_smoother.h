#ifndef ARBORSLAM_BACKEND_TERRAIN_TERRAIN_SMOOTHER_H_
#define ARBORSLAM_BACKEND_TERRAIN_TERRAIN_SMOOTHER_H_

#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "core/io/value_store.h"
#include "core/map/terrain_map.h"
#include "core/sensor/ground_sample.h"

namespace arborslam {

struct TerrainOptions {
  double cell_size = 1.0;         ///< [m], of the terrain that sweeps are laid on.
  double node_spacing = 2.0;      ///< [m], of the heights that are smoothed together with the poses.
  double keyframe_spacing = 1.0;  ///< [m] of path between the sweeps that are smoothed.
  /// [rad], standard deviation of the ground's slope under the robot: the map is made level on this assumption, since
  /// nothing measures gravity.
  double slope_sigma = 0.1;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("cell_size", cell_size);
    visit("node_spacing", node_spacing);
    visit("keyframe_spacing", keyframe_spacing);
    visit("slope_sigma", slope_sigma);
  }
};

/// The ground that one sweep saw, and from where.
struct TerrainView {
  SE2 T_map_base;
  Stored<std::vector<GroundSample>> samples;  ///< In the lidar frame.
  Tilt3 local_tilt;                           ///< Over the slope of the ground around the robot, of this sweep alone.
  Tilt3 tilt;                                 ///< Over the map: the present estimate.
};

/// Height and tilt of all sweeps and the height of the ground, in one sparse linear least-squares problem: a sweep's
/// ground lies on the terrain (heights of nodes on a grid, bilinear between), neighbouring nodes differ little, and the
/// ground under the robot is level on the average. So roll, pitch and z are consistent wherever the robot comes again,
/// and drift in height is spread over the whole run. The sweeps are eliminated, the nodes solved for by sparse
/// Cholesky. Planar poses stay as they are.
///
/// Sets `tilt` of every view and returns the terrain that they make together.
TerrainMap SmoothTerrain(const TerrainOptions& options, std::vector<TerrainView>* views);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_TERRAIN_TERRAIN_SMOOTHER_H_
