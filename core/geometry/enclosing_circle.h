#ifndef ARBORSLAM_CORE_GEOMETRY_ENCLOSING_CIRCLE_H_
#define ARBORSLAM_CORE_GEOMETRY_ENCLOSING_CIRCLE_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

struct Circle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double radius = 0.0;
};

/// The smallest circle around `points`, which are finite; of radius 0 at the origin if there are none. Takes the time
/// of sorting them, plus the cube of the corners of their convex hull at worst.
Circle EnclosingCircle(std::vector<Eigen::Vector2d> points);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_GEOMETRY_ENCLOSING_CIRCLE_H_
