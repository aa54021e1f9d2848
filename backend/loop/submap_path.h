#ifndef ARBORSLAM_BACKEND_LOOP_SUBMAP_PATH_H_
#define ARBORSLAM_BACKEND_LOOP_SUBMAP_PATH_H_

#include <Eigen/Core>
#include <limits>
#include <memory>

#include "backend/graph/pose_graph.h"
#include "core/map/submap.h"

namespace arborslam {

/// Where the keyframes of a submap were taken, to ask how far off something else was. Immutable: may be asked from
/// several threads.
class SubmapPath {
 public:
  /// @param graph holds the submap's keyframes; their poses are copied.
  SubmapPath(const Submap& submap, const PoseGraph& graph);
  SubmapPath(SubmapPath&& other) noexcept;
  ~SubmapPath();

  /// [m] from `position` in the map to the nearest keyframe; infinity if there is none. What is farther off than
  /// `max_distance` [m] may be infinitely far.
  double DistanceTo(const Eigen::Vector2d& position,
                    double max_distance = std::numeric_limits<double>::infinity()) const;

 private:
  class Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_SUBMAP_PATH_H_
