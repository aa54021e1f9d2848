#ifndef ARBORSLAM_FRONTEND_TRACKING_SWEEP_REDUCER_H_
#define ARBORSLAM_FRONTEND_TRACKING_SWEEP_REDUCER_H_

#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "core/map/terrain_map.h"
#include "core/sensor/ground_sample.h"
#include "core/sensor/lidar_sweep.h"
#include "core/sensor/planar_scan.h"
#include "frontend/projection/compact_things.h"
#include "frontend/projection/moving_object_filter.h"
#include "frontend/projection/sweep_projector.h"
#include "frontend/projection/upright_lines.h"
#include "frontend/tracking/planar_velocity.h"

namespace arborslam {

/// Which of the steps that undo the robot's motion are taken; each can be left out to see what it is good for.
struct ReductionOptions {
  bool deskew = true;  ///< Take out the robot's motion during the sweep.
  bool level = true;   ///< Stand every sweep upright; false: all are tilted as the first was.

  std::string Validate() const { return ""; }

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("deskew", deskew);
    visit("level", level);
  }
};

/// A sweep as the estimation uses it.
struct ReducedSweep {
  PlanarScan planar;                      ///< In the base frame, without what moves, compact things centred.
  std::vector<Eigen::Vector2f> to_match;  ///< [m], those points of `planar` by which it is to be matched.
  PlanarScan with_moving;                 ///< The same with it.
  std::vector<GroundSample> ground;       ///< In the lidar frame.
  bool has_ground = false;                ///< False: no ground was found, the tilt is that of the sweep before.
  Tilt3 local_tilt;                       ///< Over the slope of the ground around the robot.
  Tilt3 tilt;                             ///< Over the odometry frame's level; z likewise.
  PlanarVelocity deskewing;               ///< What the sweep was deskewed with, at its `duration`.
  int num_moving = 0;                     ///< Planar points that were left out since they move.
};

/// From sweeps to planar scans (design section 3, steps 2-4): deskews with the robot's velocity, finds the ground,
/// stands the sweep upright over the terrain seen so far, projects it and leaves out what moves. For one thread.
class SweepReducer {
 public:
  /// The options must be valid.
  SweepReducer(const ReductionOptions& reduction, const SweepProjectionOptions& projection,
               const MovingObjectOptions& moving_objects, const CompactThingOptions& compact, double terrain_cell_size);

  /// @param prediction T_odom_base of the sweep's middle.
  ReducedSweep Reduce(const LidarSweep& sweep, const SE2& prediction, const PlanarVelocity& velocity);

  /// False where deskewing is left out, or when the moments of the points are not known.
  bool CanRedeskew(const ReducedSweep& reduced) const;

  /// Deskews the planar points again, with a velocity that is known better by now: `reduced` becomes, to first order of
  /// the velocities' difference, what `Reduce` would have made of `sweep` with it. Only if `CanRedeskew`.
  void Redeskew(const LidarSweep& sweep, const PlanarVelocity& velocity, ReducedSweep* reduced) const;

  /// Forgets the terrain and what stood around: the next sweep is taken elsewhere.
  void ForgetPlace();

  /// Remembers a sweep whose pose is known by now.
  void Commit(const ReducedSweep& sweep, const SE2& T_odom_base);

  /// The part of `Commit` that remembers the terrain: `ground` [m, lidar frame] of a sweep with this pose and tilt.
  void AddTerrain(const std::vector<GroundSample>& ground, const SE2& T_odom_base, const Tilt3& tilt);

  /// What it remembers of the sweeps, but for the terrain, which their ground tells.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(projector_, moving_objects_, last_tilt_, is_first_);
  }

  /// The upright lines of the sweep last reduced, measured with its `tilt`.
  std::vector<UprightLine> LinesOfLast(const ReducedSweep& sweep) const {
    return FindUprightLines(prepared_, sweep.tilt.Rotation().cast<float>());
  }

 private:
  ReductionOptions options_;
  CompactThingOptions compact_options_;
  SweepProjector projector_;
  MovingObjectFilter moving_objects_;
  MovingObjectOptions moving_object_options_;
  bool find_moving_;
  double terrain_cell_size_;  // [m]
  PreparedSweep prepared_;    // Of the last sweep; its memory is used again.
  TerrainMap terrain_;
  Tilt3 last_tilt_;
  bool is_first_ = true;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_SWEEP_REDUCER_H_
