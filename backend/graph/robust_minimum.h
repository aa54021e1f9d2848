#ifndef ARBORSLAM_BACKEND_GRAPH_ROBUST_MINIMUM_H_
#define ARBORSLAM_BACKEND_GRAPH_ROBUST_MINIMUM_H_

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "backend/graph/robust_solver.h"

namespace arborslam {

/// The lower of two minima of a robust cost, nearly.
struct RobustMinimum {
  std::vector<Eigen::Vector3d> poses;  ///< x, y, theta [m, m, rad].
  int iterations = 0;                  ///< Of all solves together.
};

/// Seeks the least `CostOf` at `gate` c twice:
///
/// - growing, from `growing_start`: c/4 comes first, so that only loops that fit the present poses closely count. Short
///   loops correct the path before long ones are judged (much as dynamic covariance scaling does, Agarwal et al. 2013);
/// - shrinking, from `shrinking_start`: a great c comes first and all loops count, then ever fewer of those that
///   disagree with the others (graduated non-convexity, Yang et al. 2020). So loops that agree with each other remove
///   any drift. Left out when growing has brought every loop within the gate.
///
/// @param held        places of the poses that stay where they are.
/// @param num_threads with two or more, both minima are sought at once; the result is the same bits.
RobustMinimum FindRobustMinimum(const std::vector<Eigen::Vector3d>& growing_start,
                                const std::vector<Eigen::Vector3d>& shrinking_start,
                                const std::vector<GraphEdge>& edges, const std::vector<size_t>& held, double gate,
                                int num_threads);

/// The largest `ErrorOf` [standard deviations] of the edges that may be wrong; 0 if there are none.
double LargestLoopError(const std::vector<GraphEdge>& edges, const std::vector<Eigen::Vector3d>& poses);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_ROBUST_MINIMUM_H_
