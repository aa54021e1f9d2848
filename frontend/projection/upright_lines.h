#ifndef ARBORSLAM_FRONTEND_PROJECTION_UPRIGHT_LINES_H_
#define ARBORSLAM_FRONTEND_PROJECTION_UPRIGHT_LINES_H_

#include <Eigen/Core>
#include <vector>

#include "frontend/projection/sweep_projector.h"

namespace arborslam {

/// A line of returns over one another on a trunk, a post or a wall, in one column of a sweep.
struct UprightLine {
  Eigen::Vector2f direction;  ///< Unit vector from the lidar to it, base frame.
  float range;                ///< [m] in the plane.
  float slope;                ///< dr/dz: by how much farther off it is for every metre up.
  float spread;               ///< [m^2], sum of the squared heights about their mean: the slope's weight.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(direction, range, slope, spread);
  }
};

/// Finds the upright lines of a sweep below the canopy: at least three returns of a column at about one range that
/// reach over 0.4 m of height. On the average trunks stand upright, so the slopes tell how level `R_base_lidar` is.
std::vector<UprightLine> FindUprightLines(const PreparedSweep& sweep, const Eigen::Matrix3f& R_base_lidar);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_UPRIGHT_LINES_H_
