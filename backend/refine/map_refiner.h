#ifndef ARBORSLAM_BACKEND_REFINE_MAP_REFINER_H_
#define ARBORSLAM_BACKEND_REFINE_MAP_REFINER_H_

#include <string>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "core/map/leave_one_out_map.h"
#include "core/map/occupancy_grid.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

struct MapRefinementOptions {
  int num_passes = 2;    ///< How often all keyframes are matched to the corrected map; 0 leaves it out.
  double radius = 20.0;  ///< [m], a keyframe this near to a submap's path is matched to it.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("num_passes", num_passes);
    visit("radius", radius);
  }
};

/// The offline refinement: builds the submaps anew from the optimised poses, matches every keyframe to every submap
/// around it, and solves the graph of all these measurements; several times over (design section 3, step 10). Scans
/// that may lie far off, spoilt ones and those that no match holds well, are searched for in the maps of their time.
class MapRefiner {
 public:
  MapRefiner(const MapRefinementOptions& options, const OccupancyGridOptions& grid, double min_occupancy,
             double max_distance, const Matcher& matcher);

  /// One pass: measures all pairs against maps built from the poses of `graph`, and returns the graph of these
  /// measurements, not yet optimised. `submaps` gets the new cells.
  PoseGraph Remeasure(const PoseGraph& graph, const std::vector<Keyframe>& keyframes, std::vector<Submap>* submaps,
                      int num_threads) const;

 private:
  // A submap's cells at the poses of `graph`.
  std::vector<OccupiedCell> CellsOf(const Submap& submap, const PoseGraph& graph,
                                    const std::vector<Keyframe>& keyframes) const;
  // The same for leaving scans out, numbered as in the submap.
  LeaveOneOutMap LeaveOneOutMapOf(const Submap& submap, const PoseGraph& graph,
                                  const std::vector<Keyframe>& keyframes) const;

  MapRefinementOptions options_;
  OccupancyGridOptions grid_options_;
  float min_log_odds_;
  double max_distance_;
  Matcher matcher_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_REFINE_MAP_REFINER_H_
