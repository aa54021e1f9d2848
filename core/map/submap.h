#ifndef ARBORSLAM_CORE_MAP_SUBMAP_H_
#define ARBORSLAM_CORE_MAP_SUBMAP_H_

#include <vector>

#include "core/io/value_store.h"
#include "core/map/ids.h"
#include "core/map/occupancy_grid.h"

namespace arborslam {

/// A finished piece of map: what is left of an occupancy grid when no more scans come in. Its frame is the pose of its
/// first keyframe when the submap was begun (the anchor).
struct Submap {
  SubmapId id;
  std::vector<KeyframeId> keyframes;        ///< Whose scans it is made of, in order.
  Stored<std::vector<OccupiedCell>> cells;  ///< Occupied cells, in the submap's frame.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(id, keyframes, cells);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_SUBMAP_H_
