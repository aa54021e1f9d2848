#ifndef ARBORSLAM_BACKEND_GRAPH_MAP_PARTS_H_
#define ARBORSLAM_BACKEND_GRAPH_MAP_PARTS_H_

#include <cstddef>
#include <map>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "core/map/ids.h"

namespace arborslam {

/// The parts of a map whose poses relative to each other are unknown: the connected components of the graph without its
/// gaps. A graph without gaps has one part. Immutable: may be asked from several threads.
class MapParts {
 public:
  explicit MapParts(const PoseGraph& graph);

  /// Number of a node's part, from 0 on in the order of the parts' first keyframes. The node must be in the graph.
  size_t Of(NodeId id) const { return part_of_.at(id); }
  bool AreJoined(NodeId a, NodeId b) const { return num_parts_ == 1 || Of(a) == Of(b); }

  size_t num_parts() const { return num_parts_; }
  /// The part with the most keyframes, of equal ones the first; 0 in an empty graph.
  size_t main_part() const { return main_part_; }

 private:
  std::map<NodeId, size_t> part_of_;
  size_t num_parts_ = 0;
  size_t main_part_ = 0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_MAP_PARTS_H_
