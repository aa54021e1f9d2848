#ifndef ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_
#define ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_

#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/ids.h"
#include "frontend/tracking/constraint.h"

namespace ceres {
class CostFunction;
}

namespace arborslam {

/// A small factor graph over the latest poses, solved with Ceres. Poses that leave are marginalised by a Schur
/// complement into a dense prior (e.g. Sibley et al. 2010; Leutenegger et al. 2015), so that the work per keyframe does
/// not grow with the run. A copy shares nothing that changes.
class SlidingWindow {
 public:
  /// Adds a pose. Its id must be new.
  void AddNode(NodeId id, const SE2& initial);

  /// Holds a pose at its present value with the given information.
  void AddPrior(NodeId id, const Eigen::Matrix3d& information);

  /// Adds a measurement between two poses of the window. Pose and information must be finite.
  void AddConstraint(const Constraint& constraint);

  /// Moves all poses to the least squared error; none, if Ceres fails (a warning is logged).
  void Solve();

  /// Removes a pose of the window; what its factors say about the others stays as a prior at the present linearisation
  /// point. A direction in which the pose itself is unknown has nothing to say.
  void Marginalize(NodeId id);

  bool Has(NodeId id) const { return poses_.count(id) > 0; }
  const SE2& Pose(NodeId id) const { return poses_.at(id); }
  const std::map<NodeId, SE2>& poses() const { return poses_; }

  /// How many factors (priors and constraints) the window holds.
  size_t num_factors() const { return factors_.size(); }

  /// Marginal covariance (x, y, theta) of a pose, as a perturbation of its block of x, y, theta in the odometry frame
  /// [m, rad]. Infinite (in all three) when the window leaves the pose open in some direction.
  Eigen::Matrix3d Covariance(NodeId id) const;

 private:
  struct Factor {
    std::vector<NodeId> nodes;
    std::shared_ptr<ceres::CostFunction> cost;  ///< Never changed.
  };
  // Sum of J^T J and J^T r of some factors at the present poses; blocks in the order of `nodes`.
  struct Quadratic {
    Eigen::MatrixXd hessian;
    Eigen::VectorXd gradient;
  };
  Quadratic Linearize(const std::vector<NodeId>& nodes, const std::vector<Factor>& factors) const;

  std::map<NodeId, SE2> poses_;
  std::vector<Factor> factors_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_
