#ifndef ARBORSLAM_FRONTEND_TRACKING_TERRAIN_FIT_H_
#define ARBORSLAM_FRONTEND_TRACKING_TERRAIN_FIT_H_

#include <vector>

#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "core/map/terrain_map.h"
#include "core/sensor/ground_sample.h"

namespace arborslam {

/// A lidar's tilt and height as a terrain tells them.
struct TerrainFit {
  Tilt3 tilt;           ///< z in the terrain's frame.
  double rms = 0.0;     ///< [m] of the weighted residuals.
  int num_matched = 0;  ///< Samples that lie on known terrain.
};

/// Lays the ground that a sweep saw on a terrain: finds roll, pitch and z of the lidar over the known planar pose by
/// robust weighted least squares (Cauchy), to which `initial` contributes as if measured with standard deviations of
/// 5 deg and 0.3 m: so it decides where there is no terrain, and next to nothing where there is. A ground fit to one
/// sweep alone gives the tilt over the local slope; this gives the tilt over the map's level, so that trunks stay
/// upright and z is that of the map.
/// @param samples     ground in the lidar frame [m].
/// @param T_map_base  the lidar from above, in the terrain's frame.
TerrainFit FitToTerrain(const std::vector<GroundSample>& samples, const TerrainMap& terrain, const SE2& T_map_base,
                        const Tilt3& initial);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_TERRAIN_FIT_H_
