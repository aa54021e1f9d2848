#ifndef ARBORSLAM_BACKEND_LOOP_SUBMAP_TARGETS_H_
#define ARBORSLAM_BACKEND_LOOP_SUBMAP_TARGETS_H_

#include <cstddef>
#include <list>
#include <vector>

#include "core/map/submap.h"
#include "frontend/matching/match_target.h"

namespace arborslam {

/// The submaps of a map as match targets, made when first asked for; only the ones last used are kept, since a target
/// takes a hundred times the memory of its cells. For one thread.
class SubmapTargets {
 public:
  /// @param submaps      must outlive this object.
  /// @param cell_size    [m] of the grids that they come from.
  /// @param max_distance [m], D_max.
  /// @param capacity     targets to keep, at least 1.
  SubmapTargets(const std::vector<Submap>& submaps, double cell_size, double max_distance, size_t capacity);

  /// The target of `submaps[index]`; valid until `capacity` others have been asked for.
  const MatchTarget& Get(size_t index);

 private:
  struct Entry {
    size_t index;
    MatchTarget target;
  };

  const std::vector<Submap>& submaps_;
  double cell_size_;
  double max_distance_;
  size_t capacity_;
  std::list<Entry> entries_;  // Last used first.
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_SUBMAP_TARGETS_H_
