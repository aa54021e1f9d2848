#ifndef ARBORSLAM_BACKEND_GLOBAL_SOLUTION_H_
#define ARBORSLAM_BACKEND_GLOBAL_SOLUTION_H_

#include <cstddef>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/loop/loop_closer.h"
#include "backend/slam_options.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

/// How a map was made consistent.
struct GlobalSolution {
  /// Every pair that was tried, as it was tried last; accepted are those that stayed in the graph to the end.
  std::vector<LoopCandidate> loops;
  size_t num_loop_searches = 0;               ///< Near and after drift, until no more are found.
  PoseGraphSummary loop_optimization;         ///< The last of these.
  std::vector<PoseGraphSummary> refinements;  ///< One per pass.
  // [ms]
  double loop_ms = 0.0;      ///< Search for loops.
  double optimize_ms = 0.0;  ///< All solutions of the graph.
  double refine_ms = 0.0;    ///< Matching to the corrected maps.
};

/// Makes a map consistent as a whole: closes loops, optimises the graph, and refines it against the corrected maps
/// (design section 3, steps 9 and 10). Loops that the solved graph contradicts by half a metre or more, so that they
/// must be wrong by a tree or along a direction in which the scan hardly holds, are taken out before it is refined.
/// `graph` and the cells of `submaps` become those of the solution. The same bits for any number of threads.
/// @param keyframes keyframe i with id i.
GlobalSolution SolveGlobally(const SlamOptions& options, const Matcher& matcher, int num_threads,
                             const std::vector<Keyframe>& keyframes, PoseGraph* graph, std::vector<Submap>* submaps);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GLOBAL_SOLUTION_H_
