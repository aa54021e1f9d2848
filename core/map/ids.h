#ifndef ARBORSLAM_CORE_MAP_IDS_H_
#define ARBORSLAM_CORE_MAP_IDS_H_

#include <ostream>
#include <tuple>

namespace arborslam {

/// A number that names one thing of a kind and cannot be mistaken for the number of another kind. Counts from 0 in the
/// order of creation.
template <class Kind>
struct Id {
  int value = -1;

  friend bool operator==(Id a, Id b) { return a.value == b.value; }
  friend bool operator!=(Id a, Id b) { return a.value != b.value; }
  friend bool operator<(Id a, Id b) { return a.value < b.value; }
};

/// Names a keyframe: a scan that is kept.
using KeyframeId = Id<struct KeyframeKind>;
/// Names a submap.
using SubmapId = Id<struct SubmapKind>;

/// Names a variable of the estimation: the pose of a keyframe or of a submap.
struct NodeId {
  enum class Kind { kKeyframe, kSubmap };
  Kind kind = Kind::kKeyframe;
  int value = -1;

  NodeId() = default;
  NodeId(KeyframeId id) : kind(Kind::kKeyframe), value(id.value) {}  // NOLINT(google-explicit-constructor)
  NodeId(SubmapId id) : kind(Kind::kSubmap), value(id.value) {}      // NOLINT(google-explicit-constructor)

  friend bool operator==(NodeId a, NodeId b) { return a.kind == b.kind && a.value == b.value; }
  friend bool operator<(NodeId a, NodeId b) { return std::tie(a.kind, a.value) < std::tie(b.kind, b.value); }
};

/// Prints "keyframe 3" or "submap 3".
inline std::ostream& operator<<(std::ostream& stream, NodeId id) {
  return stream << (id.kind == NodeId::Kind::kKeyframe ? "keyframe " : "submap ") << id.value;
}

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_IDS_H_
