#ifndef ARBORSLAM_BACKEND_SLAM_OPTIONS_H_
#define ARBORSLAM_BACKEND_SLAM_OPTIONS_H_

#include <string>

#include "backend/graph/pose_graph.h"
#include "backend/loop/loop_closer.h"
#include "backend/loop/place_recognizer.h"
#include "backend/refine/map_refiner.h"
#include "backend/terrain/terrain_smoother.h"
#include "core/map/occupancy_grid.h"
#include "frontend/matching/matcher.h"
#include "frontend/matching/modified_hausdorff.h"
#include "frontend/matching/refinement.h"
#include "frontend/projection/compact_things.h"
#include "frontend/projection/laser_projection.h"
#include "frontend/projection/moving_object_filter.h"
#include "frontend/projection/sweep_projection.h"
#include "frontend/tracking/motion_model.h"
#include "frontend/tracking/sweep_reducer.h"
#include "frontend/tracking/tracker.h"
#include "frontend/tracking/wheel_odometry.h"

namespace arborslam {

struct WindowOptions {
  int num_keyframes = 15;  ///< Keyframes whose poses are still open to the causal estimate.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("num_keyframes", num_keyframes);
  }
};

/// Everything that can be set, one section per module.
struct SlamOptions {
  ProjectionOptions projection;
  ReductionOptions reduction;
  SweepProjectionOptions sweep;
  MovingObjectOptions dynamic;
  CompactThingOptions compact;
  MotionOptions motion;
  OdometryOptions odometry;
  OccupancyGridOptions grid;
  MhdOptions mhd;
  MatcherOptions matcher;
  RefinementOptions refinement;
  TrackerOptions tracker;
  WindowOptions window;
  LoopOptions loop;
  PlaceOptions place;
  PoseGraphOptions graph;
  MapRefinementOptions map_refinement;
  TerrainOptions terrain;

  /// Calls `visit(name, options)` for every section, in the order of the pipeline.
  template <class Visitor>
  void VisitSections(Visitor&& visit) {
    visit("projection", projection);
    visit("reduction", reduction);
    visit("sweep", sweep);
    visit("dynamic", dynamic);
    visit("compact", compact);
    visit("motion", motion);
    visit("odometry", odometry);
    visit("grid", grid);
    visit("mhd", mhd);
    visit("matcher", matcher);
    visit("refinement", refinement);
    visit("tracker", tracker);
    visit("window", window);
    visit("loop", loop);
    visit("place", place);
    visit("graph", graph);
    visit("map_refinement", map_refinement);
    visit("terrain", terrain);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_SLAM_OPTIONS_H_
