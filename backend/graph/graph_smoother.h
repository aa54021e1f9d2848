#ifndef ARBORSLAM_BACKEND_GRAPH_GRAPH_SMOOTHER_H_
#define ARBORSLAM_BACKEND_GRAPH_GRAPH_SMOOTHER_H_

#include <cstddef>
#include <string>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "core/io/g2o.h"

namespace arborslam {

/// How a pose graph of unknown origin is smoothed.
struct SmoothingOptions {
  /// Whether loops, edges between vertices that do not follow each other in the order of their ids, may be wrong.
  /// False: plain least squares of all edges.
  bool robust = true;
  /// Whether the poses that the edges alone say (orientations first, see `SolveRotationsFirst`) are tried as a start
  /// besides the vertices as they are given.
  bool rotations_first = true;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("robust", robust);
    visit("rotations_first", rotations_first);
  }
};

/// A smoothed graph and how it came about.
struct SmoothedGraph {
  PoseGraph2 graph;                             ///< Vertices at their optimum, edges without the loops dropped.
  std::vector<PoseGraph2::Edge> dropped_loops;  ///< In the order of the graph.
  size_t num_loops = 0;                         ///< That were there.
  std::vector<int> held;                        ///< Vertices that were not moved, in the order of their ids.
  size_t num_parts = 0;                         ///< That no edge joins; vertices without an edge are parts too.
  bool started_from_edges = false;              ///< Not from the vertices as given.
  double initial_chi2 = 0.0;                    ///< Of all edges at the vertices as given: sum of squared errors.
  double final_chi2 = 0.0;                      ///< Of the edges kept, after smoothing.
  int iterations = 0;                           ///< Of all solves together.
};

/// Moves the vertices of `graph` to the least squares solution of its edges. The first vertex of each part that has no
/// fixed one is held. When `robust`, loops that contradict the rest are left out: those that err by more than
/// `loop_gate` standard deviations. What a standard deviation is the loops themselves tell, by their median error: many
/// graphs claim information that is a hundred times too small or too great. Is it smaller than a tenth of what is
/// claimed, a tenth is taken. Wrong loops are looked for in the least squares solution of all edges; if there are any,
/// in the lower minimum of `FindRobustMinimum`, and then anew in the least squares solution of what is left, until they
/// stay the same.
///
/// The result is the same bits for any `num_threads`. `graph` must be one that `ReadG2o` may return.
SmoothedGraph SmoothGraph(const PoseGraph2& graph, const SmoothingOptions& options,
                          const PoseGraphOptions& graph_options, int num_threads);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_GRAPH_SMOOTHER_H_
