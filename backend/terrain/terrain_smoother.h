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

/// By how much ground samples lie too high on the average, by their range: piecewise linear, constant beyond the last.
struct RangeBias {
  std::vector<double> heights;  ///< [m], at multiples of `kSpacing`; empty: none.

  static constexpr double kSpacing = 2.0;  ///< [m]

  /// [m], at `range` [m] in the plane.
  double At(double range) const;
};

/// `samples` [m, lidar frame] of a lidar with this tilt, lowered by their bias.
std::vector<GroundSample> WithoutBias(const RangeBias& bias, const Tilt3& tilt,
                                      const std::vector<GroundSample>& samples);

struct SmoothedTerrain {
  TerrainMap terrain;  ///< That all views make together, without the bias.
  RangeBias bias;
};

/// Height and tilt of all sweeps and the height of the ground, in one sparse linear least-squares problem: a sweep's
/// ground lies on the terrain (heights of nodes on a grid, bilinear between), neighbouring nodes differ little, and the
/// ground under the robot is level on the average. So roll, pitch and z are consistent wherever the robot comes again,
/// and drift in height is spread over the whole run. The sweeps are eliminated, the nodes solved for by sparse
/// Cholesky. Planar poses stay as they are.
///
/// Grass and grazing beams make ground look higher the farther off it is, so that every sweep sees a bowl; laid on one
/// another, bowls make a map that bows. `RangeBias` is estimated together with the heights. Its part that grows with
/// the square of the range cannot be told from a bow of the whole map by the samples; the bow with the least slopes
/// under the robot is taken.
///
/// Sets `tilt` of every view.
SmoothedTerrain SmoothTerrain(const TerrainOptions& options, std::vector<TerrainView>* views);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_TERRAIN_TERRAIN_SMOOTHER_H_
