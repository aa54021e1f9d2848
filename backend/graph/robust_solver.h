#ifndef ARBORSLAM_BACKEND_GRAPH_ROBUST_SOLVER_H_
#define ARBORSLAM_BACKEND_GRAPH_ROBUST_SOLVER_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace ceres {
class CostFunction;
}

namespace arborslam {

/// A measured relative pose between two poses, by their places in a list.
struct GraphEdge {
  size_t from = 0;
  size_t to = 0;
  std::shared_ptr<ceres::CostFunction> factor;  ///< See `CreateRelativePoseFactor`.
  bool may_be_wrong = false;                    ///< Its cost is that of Geman and McClure instead of the square.
};

/// The norm r of an edge's weighted error [standard deviations] at `poses` (x, y, theta [m, m, rad]).
double ErrorOf(const GraphEdge& edge, const std::vector<Eigen::Vector3d>& poses);

/// Half the sum of all squared errors r^2, where edges that may be wrong count s^2 r^2 / (s^2 + r^2), s = `scale`.
double CostOf(const std::vector<GraphEdge>& edges, const std::vector<Eigen::Vector3d>& poses, double scale);

/// Poses under optimisation (Ceres, sparse Cholesky of SuiteSparse, one thread: Ceres adds costs up in the order in
/// which its threads finish, so that more would change the last bits).
class RobustSolver {
 public:
  /// @param poses x, y, theta [m, m, rad], at least one.
  /// @param held  places of the poses that stay where they are.
  RobustSolver(const std::vector<Eigen::Vector3d>& poses, const std::vector<GraphEdge>& edges,
               const std::vector<size_t>& held = {0});
  ~RobustSolver();

  /// Goes towards the least `CostOf` at `scale`. Stops when a step lessens it by a smaller share than `tolerance`.
  void Solve(double scale, int max_iterations, double tolerance);

  const std::vector<Eigen::Vector3d>& poses() const { return poses_; }
  double final_cost() const { return final_cost_; }  ///< After the last `Solve`; infinite if it failed.
  int iterations() const { return iterations_; }     ///< Of all calls of `Solve`.

 private:
  class Problem;

  std::vector<Eigen::Vector3d> poses_;
  std::unique_ptr<Problem> problem_;
  double final_cost_ = 0.0;
  int iterations_ = 0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_ROBUST_SOLVER_H_
