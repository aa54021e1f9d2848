#ifndef ARBORSLAM_CORE_SIMULATION_CLOSED_PATH_H_
#define ARBORSLAM_CORE_SIMULATION_CLOSED_PATH_H_

#include <Eigen/Core>
#include <vector>

#include "core/geometry/se2.h"

namespace arborslam {

/// A closed path of straight lines joined by circular arcs, by its length.
class ClosedPath {
 public:
  /// The path from `corners[0]` to each next corner [m] and from the last back to the first; at least three, each apart
  /// from the next. Corners are rounded with `turn_radius` [m], or less where the neighbouring lines are too short.
  ClosedPath(const std::vector<Eigen::Vector2d>& corners, double turn_radius);

  /// [m], once around.
  double Length() const { return length_; }

  /// Position and direction of travel at `distance` [m] along the path from its beginning: the end of the rounding of
  /// corners[0], or corners[0] itself where the path goes straight on. Beyond the length it goes around again.
  SE2 At(double distance) const;

 private:
  // A line (curvature 0) or an arc.
  struct Piece {
    double begin;      // [m] along the path.
    SE2 pose;          // Where it begins, in the direction of travel.
    double curvature;  // [1/m], positive to the left.
  };

  std::vector<Piece> pieces_;
  double length_ = 0.0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_CLOSED_PATH_H_
