#ifndef ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_
#define ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_

#include <Eigen/Core>
#include <map>
#include <vector>

#include "backend/factors/marginal_prior_factor.h"
#include "core/geometry/se2.h"
#include "core/map/ids.h"
#include "frontend/tracking/constraint.h"

namespace arborslam {

/// A small factor graph over the latest poses, solved with Ceres. Poses that leave are marginalised by a Schur
/// complement into a dense prior (e.g. Sibley et al. 2010; Leutenegger et al. 2015), so that the work per keyframe does
/// not grow with the run.
class SlidingWindow {
 public:
  /// Adds a pose. Its id must be new.
  void AddNode(NodeId id, const SE2& initial);

  /// Holds a pose at its present value with the given information.
  void AddPrior(NodeId id, const Eigen::Matrix3d& information);

  /// Adds a measurement between two poses of the window.
  void AddConstraint(const Constraint& constraint);

  /// Moves all poses to the least squared error.
  void Solve();

  /// Removes a pose; what its factors say about the others stays as a prior at the present linearisation point.
  void Marginalize(NodeId id);

  bool Has(NodeId id) const { return poses_.count(id) > 0; }
  const SE2& Pose(NodeId id) const { return poses_.at(id); }
  const std::map<NodeId, SE2>& poses() const { return poses_; }

  /// Marginal covariance (x, y, theta) of a pose, as a perturbation of its block of x, y, theta in the odometry frame.
  Eigen::Matrix3d Covariance(NodeId id) const;

 private:
  struct Prior {
    std::vector<NodeId> nodes;
    MarginalPrior prior;
  };
  // Sum of J^T J and J^T r of some factors at the present poses; blocks in the order of `nodes`.
  struct Quadratic {
    Eigen::MatrixXd hessian;
    Eigen::VectorXd gradient;
  };
  Quadratic Linearize(const std::vector<NodeId>& nodes, const std::vector<Constraint>& constraints,
                      const std::vector<Prior>& priors) const;

  std::map<NodeId, SE2> poses_;
  std::vector<Constraint> constraints_;
  std::vector<Prior> priors_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_
