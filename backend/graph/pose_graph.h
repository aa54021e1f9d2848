#ifndef ARBORSLAM_BACKEND_GRAPH_POSE_GRAPH_H_
#define ARBORSLAM_BACKEND_GRAPH_POSE_GRAPH_H_

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/ids.h"
#include "frontend/tracking/constraint.h"

namespace arborslam {

struct PoseGraphOptions {
  int max_iterations = 50;  ///< Of each solve to convergence.
  /// [standard deviations], norm of a loop's weighted error (x, y and theta together) up to which it is taken to be
  /// right. 99 % of right loops err by less than 3.4 if their covariances are true; real ones err by up to three times
  /// what they claim. Wrong ones, a tree or a row away, err by hundreds.
  double loop_gate = 10.0;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("max_iterations", max_iterations);
    visit("loop_gate", loop_gate);
  }
};

/// How an optimisation went.
struct PoseGraphSummary {
  double initial_cost = 0.0;  ///< Of the constraints that are kept, at the poses as they were.
  double final_cost = 0.0;    ///< Of the same after optimisation: half of their costs, see `PoseGraph::Optimize`.
  int iterations = 0;         ///< Of all solves together.
  std::vector<Constraint> dropped_loops;  ///< In the order in which they were added.
};

/// All keyframes and submaps of a run and everything measured between them.
class PoseGraph {
 public:
  /// Adds a pose, T_map_node. Its id must be new.
  void AddNode(NodeId id, const SE2& T_map_node);
  /// Moves a node.
  void SetPose(NodeId id, const SE2& T_map_node) { poses_.at(id) = T_map_node; }
  /// Adds a measurement between two nodes of the graph. Pose and information must be finite.
  void AddConstraint(const Constraint& constraint);

  /// Removes the constraints for which `is_wrong`, and returns them in the order in which they were added. No pose
  /// moves.
  std::vector<Constraint> Remove(const std::function<bool(const Constraint&)>& is_wrong);

  /// Drops the loops that are wrong and moves all poses but the first keyframe's to the least cost of all other
  /// constraints (sparse Cholesky of SuiteSparse). Poses without a constraint stay where they are.
  ///
  /// A constraint costs its squared weighted error r^2; a loop, which may be wrong, costs c^2 r^2 / (c^2 + r^2) (Geman
  /// and McClure), c = `loop_gate`. This cost has many minima. The lower of two is taken (see `FindRobustMinimum`),
  /// loops that err by more than c there are dropped, and the rest is solved to convergence.
  ///
  /// @param num_threads with two or more, both minima are sought at once; the result is the same bits.
  PoseGraphSummary Optimize(const PoseGraphOptions& options, int num_threads);

  const SE2& Pose(NodeId id) const { return poses_.at(id); }
  const std::map<NodeId, SE2>& poses() const { return poses_; }
  const std::vector<Constraint>& constraints() const { return constraints_; }

 private:
  std::map<NodeId, SE2> poses_;
  std::vector<Constraint> constraints_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_POSE_GRAPH_H_
