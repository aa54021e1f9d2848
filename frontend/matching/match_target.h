#ifndef ARBORSLAM_FRONTEND_MATCHING_MATCH_TARGET_H_
#define ARBORSLAM_FRONTEND_MATCHING_MATCH_TARGET_H_

#include <Eigen/Core>
#include <vector>

#include "core/map/distance_field.h"
#include "core/map/min_pyramid.h"
#include "core/map/occupancy_grid.h"

namespace arborslam {

/// What a scan is matched to: the occupied cells of a map, ready for look-up. Built from the evidence at one moment;
/// immutable but for the pyramid, which is built when first asked for.
class MatchTarget {
 public:
  /// An occupied cell as a measurement model sees it.
  struct Landmark {
    Eigen::Vector2f centroid;     ///< [m], where in the cell the returns lie.
    float weight;                 ///< (0, 1], how firmly the evidence says "occupied".
    Eigen::Vector3f information;  ///< xx, xy, yy of the shape: 1 across the surface, less along it.
  };

  /// @param cells        the occupied cells, in the target's frame.
  /// @param cell_size    [m] of the grid they come from.
  /// @param max_distance [m], D_max.
  MatchTarget(const std::vector<OccupiedCell>& cells, double cell_size, double max_distance);

  const DistanceField& field() const { return field_; }
  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  bool empty() const { return landmarks_.empty(); }

  /// The landmark nearest to `point` [m] as far as its cell tells, or nullptr beyond D_max.
  const Landmark* Nearest(const Eigen::Vector2f& point) const {
    const int index = field_.Nearest(point);
    return index < 0 ? nullptr : &landmarks_[static_cast<size_t>(index)];
  }

  /// A pyramid of at least `num_levels` levels. Not to be called from two threads at once.
  const MinPyramid& Pyramid(int num_levels) const;

 private:
  // Fits the spread of the landmarks around each one.
  void FitShapes();

  std::vector<Landmark> landmarks_;
  DistanceField field_;
  mutable std::vector<MinPyramid> pyramid_;  // Empty or one.
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MATCHING_MATCH_TARGET_H_
