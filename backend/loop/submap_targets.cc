#include "backend/loop/submap_targets.h"

#include <algorithm>

namespace arborslam {

SubmapTargets::SubmapTargets(const std::vector<Submap>& submaps, double cell_size, double max_distance, size_t capacity)
    : submaps_(submaps), cell_size_(cell_size), max_distance_(max_distance), capacity_(capacity) {}

const MatchTarget& SubmapTargets::Get(size_t index) {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [index](const Entry& entry) { return entry.index == index; });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
  } else {
    entries_.push_front({index, MatchTarget(*submaps_[index].cells.Get(), cell_size_, max_distance_)});
    if (entries_.size() > capacity_) entries_.pop_back();
  }
  return entries_.front().target;
}

}  // namespace arborslam
