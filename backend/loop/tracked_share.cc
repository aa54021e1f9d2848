#include "backend/loop/tracked_share.h"

#include <algorithm>

namespace arborslam {

TrackedShare::TrackedShare(const std::vector<Keyframe>& keyframes) : num_before_{0} {
  num_before_.reserve(keyframes.size() + 1);
  for (const Keyframe& keyframe : keyframes) num_before_.push_back(num_before_.back() + (keyframe.is_inserted ? 1 : 0));
}

double TrackedShare::Of(const Submap& submap) const {
  if (submap.keyframes.empty()) return 0.0;
  return Between(static_cast<size_t>(submap.keyframes.front().value),
                 static_cast<size_t>(submap.keyframes.back().value) + 1);
}

double TrackedShare::Around(size_t index, size_t reach) const {
  return Between(index - std::min(index, reach), std::min(index + reach + 1, num_before_.size() - 1));
}

double TrackedShare::Between(size_t first, size_t end) const {
  return static_cast<double>(num_before_[end] - num_before_[first]) / static_cast<double>(end - first);
}

}  // namespace arborslam
