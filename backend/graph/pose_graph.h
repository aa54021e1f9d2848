#ifndef ARBORSLAM_BACKEND_GRAPH_POSE_GRAPH_H_
#define ARBORSLAM_BACKEND_GRAPH_POSE_GRAPH_H_

#include <map>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/ids.h"
#include "frontend/tracking/constraint.h"

namespace arborslam {

struct PoseGraphOptions {
  int max_iterations = 50;
  double loop_loss_scale = 3.0;  ///< [standard deviations], where a loop's cost turns from quadratic to logarithmic.
  double loop_gate = 4.0;        ///< [standard deviations], a loop that errs by more after optimisation is dropped.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("max_iterations", max_iterations);
    visit("loop_loss_scale", loop_loss_scale);
    visit("loop_gate", loop_gate);
  }
};

/// How an optimisation went.
struct PoseGraphSummary {
  double initial_cost = 0.0;
  double final_cost = 0.0;
  int iterations = 0;
  int num_loops_dropped = 0;
};

/// All keyframes and submaps of a run and everything measured between them.
class PoseGraph {
 public:
  /// Adds a pose, T_map_node. Its id must be new.
  void AddNode(NodeId id, const SE2& T_map_node);
  /// Moves a node.
  void SetPose(NodeId id, const SE2& T_map_node) { poses_.at(id) = T_map_node; }
  /// Adds a measurement between two nodes of the graph.
  void AddConstraint(const Constraint& constraint);

  /// Moves all poses but the first keyframe's to the least squared error (sparse Cholesky of SuiteSparse). Loops, which
  /// may be wrong, have a robust loss (Cauchy); then those that still disagree are dropped and the rest is solved
  /// again.
  PoseGraphSummary Optimize(const PoseGraphOptions& options, int num_threads);

  const SE2& Pose(NodeId id) const { return poses_.at(id); }
  const std::map<NodeId, SE2>& poses() const { return poses_; }
  const std::vector<Constraint>& constraints() const { return constraints_; }

 private:
  PoseGraphSummary Solve(const PoseGraphOptions& options, int num_threads);

  std::map<NodeId, SE2> poses_;
  std::vector<Constraint> constraints_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_POSE_GRAPH_H_
