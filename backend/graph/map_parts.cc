#include "backend/graph/map_parts.h"

#include <algorithm>
#include <numeric>

namespace arborslam {

MapParts::MapParts(const PoseGraph& graph) {
  // Ids sort keyframes first: a part's representative is its first keyframe.
  std::map<NodeId, size_t> index;
  for (const auto& [id, pose] : graph.poses()) index.emplace(id, index.size());
  std::vector<size_t> parent(index.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  const auto root_of = [&parent](size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  bool has_gaps = false;
  for (const Constraint& constraint : graph.constraints()) {
    has_gaps |= constraint.kind == Constraint::Kind::kGap;
    if (constraint.kind == Constraint::Kind::kGap) continue;
    const size_t a = root_of(index.at(constraint.from));
    const size_t b = root_of(index.at(constraint.to));
    parent[std::max(a, b)] = std::min(a, b);
  }
  if (!has_gaps) std::fill(parent.begin(), parent.end(), size_t{0});
  std::map<size_t, size_t> number;  // Of the part with a root.
  std::vector<size_t> num_keyframes;
  for (const auto& [id, i] : index) {
    const size_t part = number.emplace(root_of(i), number.size()).first->second;
    num_keyframes.resize(std::max(num_keyframes.size(), part + 1), 0);
    num_keyframes[part] += id.kind == NodeId::Kind::kKeyframe ? 1 : 0;
    part_of_.emplace(id, part);
  }
  num_parts_ = number.size();
  if (num_parts_ > 0) {
    main_part_ =
        static_cast<size_t>(std::max_element(num_keyframes.begin(), num_keyframes.end()) - num_keyframes.begin());
  }
}

}  // namespace arborslam
