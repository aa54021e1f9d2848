#ifndef ARBORSLAM_BACKEND_LOOP_TRACKED_SHARE_H_
#define ARBORSLAM_BACKEND_LOOP_TRACKED_SHARE_H_

#include <cstddef>
#include <vector>

#include "backend/keyframe.h"
#include "core/map/submap.h"

namespace arborslam {

/// How well a run was tracked from place to place: where most scans could not be put into the maps, these hold a few
/// scattered things whose arrangement is a guess.
class TrackedShare {
 public:
  /// @param keyframes keyframe i with id i.
  explicit TrackedShare(const std::vector<Keyframe>& keyframes);

  /// Share, in [0, 1], of the keyframes from the submap's first to its last that could be put into maps; 0 for one
  /// without keyframes.
  double Of(const Submap& submap) const;
  /// The same among the `reach` keyframes before keyframe `index`, itself, and the `reach` ones after it.
  double Around(size_t index, size_t reach) const;

 private:
  double Between(size_t first, size_t end) const;

  std::vector<size_t> num_before_;  // Of those that could, before keyframe i.
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_TRACKED_SHARE_H_
