#ifndef ARBORSLAM_CORE_SIMULATION_ORCHARD_GRAPH_H_
#define ARBORSLAM_CORE_SIMULATION_ORCHARD_GRAPH_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/io/g2o.h"

namespace arborslam {

/// What a run of any length through an orchard of straight rows measures: row after row, driven back and forth.
struct OrchardGraphOptions {
  int seed = 1;               ///< Everything random follows from it.
  int num_keyframes = 1000;   ///< At least 2.
  double row_length = 100.0;  ///< [m] driven along each row.
  double row_spacing = 4.0;   ///< [m] from row to row.
  double step = 0.5;          ///< [m] from keyframe to keyframe.
  int submap_interval = 50;   ///< [keyframes] from one submap to the next; each lives for two of these.
  int loop_stride = 4;        ///< Every so many keyframes, the submaps beside it in the row before are matched.
  double loop_reach = 12.0;   ///< [m] from a keyframe to where such a submap began, at most.
  // Standard deviations of what is measured.
  double motion_translation = 0.03;  ///< [m]
  double motion_rotation = 0.01;     ///< [rad]
  double match_translation = 0.01;   ///< [m], of a scan matched to an active submap.
  double match_rotation = 0.003;     ///< [rad]
  double loop_translation = 0.02;    ///< [m]
  double loop_rotation = 0.005;      ///< [rad]

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("seed", seed);
    visit("num_keyframes", num_keyframes);
    visit("row_length", row_length);
    visit("row_spacing", row_spacing);
    visit("step", step);
    visit("submap_interval", submap_interval);
    visit("loop_stride", loop_stride);
    visit("loop_reach", loop_reach);
    visit("motion_translation", motion_translation);
    visit("motion_rotation", motion_rotation);
    visit("match_translation", match_translation);
    visit("match_rotation", match_rotation);
    visit("loop_translation", loop_translation);
    visit("loop_rotation", loop_rotation);
  }
};

/// The pose graph of such a run, as `Slam` makes them, before loops are optimised.
struct OrchardGraph {
  size_t num_keyframes = 0;
  std::vector<SE2> truth;  ///< T_map_vertex by id: keyframes come first, submaps follow them.
  /// Vertices where the run alone puts them, which drifts. Edges: motion between successive keyframes, scans matched to
  /// the two active submaps, a submap's anchor in its first keyframe; then the loops.
  PoseGraph2 graph;
  size_t first_loop = 0;  ///< From here on edges are loops.
};

/// @param options valid ones.
OrchardGraph SimulateOrchardGraph(const OrchardGraphOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_ORCHARD_GRAPH_H_
