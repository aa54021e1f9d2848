#ifndef ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_
#define ARBORSLAM_BACKEND_WINDOW_SLIDING_WINDOW_H_

#include <Eigen/Core>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "backend/factors/marginal_prior_factor.h"
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

  /// All that the window holds.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(poses_, factors_);
    if constexpr (std::decay_t<Visitor>::kIsReading) {
      for (Factor& factor : factors_) {
        visit.Check(IsWhole(factor), "a factor of the window does not go with its poses");
        factor.cost = CostOf(factor.source);
      }
    }
  }

  /// How many factors (priors and constraints) the window holds.
  size_t num_factors() const { return factors_.size(); }

  /// Marginal covariance (x, y, theta) of a pose, as a perturbation of its block of x, y, theta in the odometry frame
  /// [m, rad]. Infinite (in all three) when the window leaves the pose open in some direction.
  Eigen::Matrix3d Covariance(NodeId id) const;

 private:
  // What a factor says: a measurement or a prior; the other one is void.
  struct Source {
    explicit Source(const Constraint& measured) : is_prior(false), measurement(measured) {}
    explicit Source(MarginalPrior left) : is_prior(true), prior(std::move(left)) {}
    Source() : Source(MarginalPrior()) {}

    bool is_prior;
    Constraint measurement{{}, {}, {}, Eigen::Matrix3d::Zero()};
    MarginalPrior prior;

    template <class Visitor>
    void VisitState(Visitor&& visit) {
      visit(is_prior);
      if (is_prior) {
        visit(prior);
      } else {
        visit(measurement);
      }
    }
  };
  struct Factor {
    std::vector<NodeId> nodes;
    Source source;                              ///< What `cost` says.
    std::shared_ptr<ceres::CostFunction> cost;  ///< Never changed.

    template <class Visitor>
    void VisitState(Visitor&& visit) {
      visit(nodes, source);
    }
  };
  static std::shared_ptr<ceres::CostFunction> CostOf(const Source& source);
  // Whether the factor's nodes are in the window and as many as its source speaks of.
  bool IsWhole(const Factor& factor) const;
  void AddFactor(std::vector<NodeId> nodes, Source source);

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
