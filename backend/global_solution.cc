#include "backend/global_solution.h"

#include <algorithm>
#include <map>
#include <utility>

#include "backend/graph/map_parts.h"
#include "backend/loop/drifted_loops.h"
#include "backend/refine/map_refiner.h"
#include "core/stopwatch.h"

namespace arborslam {
namespace {

// Searches for loops that follow on each other: what was too far off is near once its neighbours are closed.
constexpr int kMaxSearches = 20;
// Once no more loops are found, none may lie farther than this from where it was found: less than to the next tree or
// row. Before, a right one may only because the map is still bent.
constexpr double kGreatestShift = 0.5;  // [m]
// [standard deviations], less is no contradiction: a loop may leave a direction open.
constexpr double kContradiction = 5.0;

size_t NumAccepted(const LoopsByPair& by_pair) {
  return static_cast<size_t>(
      std::count_if(by_pair.begin(), by_pair.end(), [](const auto& entry) { return entry.second.accepted; }));
}

// Adds to the graph and to `by_pair` what a search found; returns true if any of it was accepted.
bool AddLoops(std::vector<LoopCandidate> loops, PoseGraph* graph, LoopsByPair* by_pair) {
  bool has_accepted = false;
  for (LoopCandidate& loop : loops) {
    LoopCandidate& known = (*by_pair)[{loop.submap, loop.keyframe}];
    if (known.accepted) continue;
    if (loop.accepted) {
      graph->AddConstraint(
          {loop.submap, loop.keyframe, loop.match.pose, loop.match.information, Constraint::Kind::kLoop});
      has_accepted = true;
    }
    known = std::move(loop);
  }
  return has_accepted;
}

// Moves parts of the map whose relative poses were unknown to where the accepted `loops` between them have them, so
// that the optimisation begins near its minimum: each to the part with the lower number, the first loop deciding.
void PlaceParts(const std::vector<LoopCandidate>& loops, PoseGraph* graph) {
  const MapParts parts(*graph);
  if (parts.num_parts() < 2) return;
  std::map<size_t, size_t> placed_in;
  const auto root_of = [&placed_in](size_t part) {
    while (placed_in.count(part) > 0) part = placed_in.at(part);
    return part;
  };
  for (const LoopCandidate& loop : loops) {
    if (!loop.accepted) continue;
    const size_t of_submap = root_of(parts.Of(loop.submap));
    const size_t of_keyframe = root_of(parts.Of(loop.keyframe));
    if (of_submap == of_keyframe) continue;
    // T_new_old of the part that moves.
    const SE2 T_map_keyframe = graph->Pose(loop.submap) * loop.match.pose;
    SE2 move = T_map_keyframe * graph->Pose(loop.keyframe).Inverse();
    if (of_submap > of_keyframe) move = move.Inverse();
    const size_t moved = std::max(of_submap, of_keyframe);
    for (const auto& [id, pose] : graph->poses()) {
      if (root_of(parts.Of(id)) == moved) graph->SetPose(id, move * pose);
    }
    placed_in[moved] = std::min(of_submap, of_keyframe);
  }
}

// True if the graph places the two far from where they were found.
bool IsContradicted(const Constraint& constraint, const PoseGraph& graph) {
  const SE2 T_from_to = graph.Pose(constraint.from).Inverse() * graph.Pose(constraint.to);
  const Eigen::Vector3d error = (constraint.T_from_to.Inverse() * T_from_to).vector();
  return error.head<2>().norm() > kGreatestShift &&
         error.dot(constraint.information * error) > kContradiction * kContradiction;
}

void RefuseDropped(const std::vector<Constraint>& dropped_loops, LoopsByPair* by_pair) {
  for (const Constraint& dropped : dropped_loops) {
    // Of a merged map, loops of the sessions by themselves may be among them.
    const auto loop = by_pair->find({SubmapId{dropped.from.value}, KeyframeId{dropped.to.value}});
    if (loop == by_pair->end()) continue;
    loop->second.accepted = false;
    loop->second.reason = kContradictsOthers;
  }
}

void CloseLoops(const SlamOptions& options, const Matcher& matcher, int num_threads,
                const std::vector<Keyframe>& keyframes, const std::vector<Submap>& submaps, PoseGraph* graph,
                GlobalSolution* solution) {
  const LoopCloser closer(options.loop, options.matcher, matcher, options.grid);
  const DriftedLoopFinder drifted(options.loop, options.place, options.matcher, matcher, options.grid.cell_size);
  const PoseGraph tracked = *graph;
  LoopsByPair by_pair;
  Stopwatch stopwatch;
  const auto optimize = [&] {
    solution->loop_optimization = graph->Optimize(options.graph, num_threads);
    RefuseDropped(solution->loop_optimization.dropped_loops, &by_pair);
  };
  bool is_near = true;  // The next search is that of the closer.
  for (int search = 0; search < kMaxSearches; ++search) {
    const size_t num_before = NumAccepted(by_pair);
    std::vector<LoopCandidate> found = is_near
                                           ? closer.FindAll(*graph, tracked, keyframes, submaps, by_pair, num_threads)
                                           : drifted.FindAll(*graph, keyframes, submaps, num_threads);
    if (!is_near) PlaceParts(found, graph);
    const bool has_accepted = AddLoops(std::move(found), graph, &by_pair);
    solution->loop_ms += stopwatch.Lap();
    ++solution->num_loop_searches;
    if (search == 0 || has_accepted) optimize();
    solution->optimize_ms += stopwatch.Lap();
    const bool has_grown = NumAccepted(by_pair) > num_before;
    if (!is_near && !has_grown) break;
    is_near = has_grown;
  }
  const auto is_contradicted = [graph](const Constraint& constraint) {
    return constraint.kind == Constraint::Kind::kLoop && IsContradicted(constraint, *graph);
  };
  while (true) {
    const std::vector<Constraint> dropped = graph->Remove(is_contradicted);
    if (dropped.empty()) break;
    RefuseDropped(dropped, &by_pair);
    optimize();
  }
  solution->optimize_ms += stopwatch.Lap();
  solution->loops.reserve(by_pair.size());
  for (auto& [pair, loop] : by_pair) solution->loops.push_back(std::move(loop));
}

}  // namespace

GlobalSolution SolveGlobally(const SlamOptions& options, const Matcher& matcher, int num_threads,
                             const std::vector<Keyframe>& keyframes, PoseGraph* graph, std::vector<Submap>* submaps) {
  GlobalSolution solution;
  CloseLoops(options, matcher, num_threads, keyframes, *submaps, graph, &solution);
  Stopwatch stopwatch;
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
