#ifndef ARBORSLAM_FRONTEND_PROJECTION_SWEEP_PROJECTOR_H_
#define ARBORSLAM_FRONTEND_PROJECTION_SWEEP_PROJECTOR_H_

#include <Eigen/Core>
#include <vector>

#include "core/sensor/ground_sample.h"
#include "core/sensor/lidar_sweep.h"
#include "core/sensor/planar_scan.h"
#include "frontend/projection/canopy_height.h"
#include "frontend/projection/deskew.h"
#include "frontend/projection/ground_fit.h"
#include "frontend/projection/ground_model.h"
#include "frontend/projection/lowest_returns.h"
#include "frontend/projection/sweep_projection.h"

namespace arborslam {

/// A sweep with its distortion by motion taken out and the ground under it found.
struct PreparedSweep {
  double stamp = 0.0;                   ///< [s], the middle of the sweep.
  std::vector<float> phases;            ///< As of `PointPhases`; empty if the points cannot be deskewed.
  std::vector<Eigen::Vector3f> points;  ///< [m], in the lidar frame of the sweep's middle, all of the sweep's.
  std::vector<float> heights;           ///< [m], of each point over the ground.
  GroundFit fit;                        ///< Of this sweep; not `ok` when it saw no ground.
  /// The ground that counts: `fit` if it is `ok`, else the last one that was, else a level one at a usual height.
  GroundFit ground;
  float lidar_height = 0.0f;          ///< [m], of the lidar over the ground right below it, which may not be plane.
  float mean_canopy_height = 0.0f;    ///< [m], that given or that estimated so far.
  float column_width = 0.0f;          ///< [rad], between the sensor's columns.
  std::vector<GroundSample> samples;  ///< Ground, in the lidar frame; empty if `fit` is not `ok`.
};

/// From raw sweeps to planar scans (design 3.2-3.4): phases, deskewing, ground fit, ground model, projection. It
/// remembers the last ground, the canopy and the sensor's columns, so sweeps must come in order; the same sequence of
/// calls gives the same result. For one thread.
class SweepProjector {
 public:
  /// `options` must be valid.
  explicit SweepProjector(const SweepProjectionOptions& options);

  /// Everything but the projection.
  /// @param motion   of the lidar during the sweep; zero leaves the points as they are.
  /// @param recycled its memory is used again.
  PreparedSweep Prepare(const LidarSweep& sweep, const SweepMotion& motion, PreparedSweep recycled = {});

  /// The planar scan in the base frame that `R_base_lidar` gives: the caller's own attitude of the lidar (see
  /// core/geometry/tilt.h), or `LevelRotation(prepared.ground.normal)`, which has the ground level.
  PlanarScan Project(const PreparedSweep& prepared, const Eigen::Matrix3f& R_base_lidar);

  /// What it remembers of the sweeps.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(canopy_height_, last_ground_, column_width_);
  }

 private:
  // Replaces the fit where all returns show another ground than the lowest ones do: when no ground is known yet, and
  // where many of the lowest returns are ghosts.
  void CheckFit(PreparedSweep* prepared);
  // Finds the ground by all returns where many of the lowest are below any that `expected` may have become (mirrored by
  // puddles, of multipath), and the lowest returns and the fit without those below it.
  void FitAmongGhosts(const GroundFit& expected, PreparedSweep* prepared);

  SweepProjectionOptions options_;
  LowestReturns lowest_returns_;
  GroundModel ground_model_;
  CanopyHeight canopy_height_;
  SweepProjection projection_;
  GroundFit last_ground_;
  float column_width_ = 0.0f;  // [rad], 0: not yet known.
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_SWEEP_PROJECTOR_H_
