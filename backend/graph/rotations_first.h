#ifndef ARBORSLAM_BACKEND_GRAPH_ROTATIONS_FIRST_H_
#define ARBORSLAM_BACKEND_GRAPH_ROTATIONS_FIRST_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/se2.h"

namespace arborslam {

/// A measured pose of `to` seen from `from`, places in a list of poses.
struct RelativePose {
  size_t from = 0;
  size_t to = 0;
  SE2 T_from_to;
  Eigen::Matrix3d information;  ///< (x, y, theta) in the frame of `to`; positive definite.
};

/// Poses (x, y, theta [m, m, rad]) near the least squares solution of all measurements, found without any guess: the
/// orientations by chordal relaxation (Carlone et al. 2015: unit vectors that may take any length make the problem
/// linear), then the positions, whose problem is linear once orientations are known. Both by sparse Cholesky.
///
/// @param poses        those at the places `held` are kept, the others not looked at.
/// @param held         at least one in each part that measurements join. Nothing is returned when one is missing, or
///                     when the numbers are beyond what can be solved.
std::optional<std::vector<Eigen::Vector3d>> SolveRotationsFirst(const std::vector<Eigen::Vector3d>& poses,
                                                                const std::vector<RelativePose>& measurements,
                                                                const std::vector<size_t>& held);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_ROTATIONS_FIRST_H_
