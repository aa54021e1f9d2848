#ifndef ARBORSLAM_CORE_SIMULATION_SPLINE_PATH_H_
#define ARBORSLAM_CORE_SIMULATION_SPLINE_PATH_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geometry/se2.h"
#include "core/simulation/closed_path.h"

namespace arborslam {

/// A closed path whose heading and curvature have no jumps: a uniform cubic B-spline with control points along a
/// `ClosedPath`, whose corners it takes a little tighter.
class SplinePath {
 public:
  /// @param spacing [m] between control points, about.
  /// @param wander [m], how far the path strays slowly to the sides of `path`; the same for the same `seed`.
  SplinePath(const ClosedPath& path, double spacing, double wander, uint64_t seed);

  /// [m], of the closed path that it follows; its own length is a little less in tight turns.
  double Length() const { return spacing_ * static_cast<double>(points_.size()); }

  /// Position and direction of travel at `distance` [m] along the path that it follows. Beyond the length it goes
  /// around again.
  SE2 At(double distance) const;

 private:
  double spacing_;
  std::vector<Eigen::Vector2d> points_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_SPLINE_PATH_H_
