#include "backend/global_solution.h"

#include "backend/refine/map_refiner.h"
#include "core/stopwatch.h"

namespace arborslam {

GlobalSolution SolveGlobally(const SlamOptions& options, const Matcher& matcher, int num_threads,
                             const std::vector<Keyframe>& keyframes, PoseGraph* graph, std::vector<Submap>* submaps) {
  GlobalSolution solution;
  Stopwatch stopwatch;
  const LoopCloser closer(options.loop, options.matcher, matcher, options.grid.cell_size);
  solution.loops = closer.FindAll(*graph, keyframes, *submaps, num_threads);
  for (const LoopCandidate& loop : solution.loops) {
    if (!loop.accepted) continue;
    graph->AddConstraint(
        {loop.submap, loop.keyframe, loop.match.pose, loop.match.information, Constraint::Kind::kLoop});
  }
  solution.loop_ms = stopwatch.Lap();
  solution.loop_optimization = graph->Optimize(options.graph, num_threads);
  solution.optimize_ms = stopwatch.Lap();

  const MapRefiner refiner(options.map_refinement, options.grid, options.tracker.min_occupancy,
                           options.matcher.max_distance, matcher);
  for (int pass = 0; pass < options.map_refinement.num_passes; ++pass) {
    *graph = refiner.Remeasure(*graph, keyframes, submaps, num_threads);
    solution.refine_ms += stopwatch.Lap();
    solution.refinements.push_back(graph->Optimize(options.graph, num_threads));
    solution.optimize_ms += stopwatch.Lap();
  }
  return solution;
}

}  // namespace arborslam
