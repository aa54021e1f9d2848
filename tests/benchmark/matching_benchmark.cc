// What it costs to match a scan to a map, one scan per iteration.

#include <benchmark/benchmark.h>

#include <cmath>
#include <optional>

#include "core/geometry/angles.h"
#include "frontend/matching/branch_and_bound.h"
#include "frontend/matching/matcher.h"
#include "frontend/matching/refinement.h"
#include "frontend/tracking/tracker.h"
#include "tests/benchmark/simulated_run.h"

namespace arborslam {
namespace {

SearchWindow NearWindow() {
  const TrackerOptions options;
  return {options.near_translation,
          options.near_rotation,
          options.near_rotation_step,
          {options.translation_penalty, options.rotation_penalty}};
}

SearchWindow WideWindow() {
  const TrackerOptions options;
  return {options.wide_translation,
          options.wide_rotation,
          options.wide_rotation_step,
          {options.translation_penalty, options.rotation_penalty}};
}

// Counters: nodes scored per scan, and the share of scans whose pose was found within half a metre and 0.1 rad.
void BM_BranchAndBound(benchmark::State& state, const SearchWindow& window) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  const MatcherOptions matcher;
  // The pyramid is built once for many scans.
  mapped.target.Pyramid(6);
  size_t i = 0;
  double num_scored = 0.0;
  double num_found = 0.0;
  for (auto _ : state) {
    const Query& query = mapped.queries[i];
    const std::optional<SearchResult> found =
        BranchAndBound(mapped.target, query.sample, query.prediction, window, MhdOptions(), matcher.max_distance);
    if (found.has_value()) {
      num_scored += static_cast<double>(found->num_scored);
      num_found += (found->pose.translation() - query.truth.translation()).norm() < 0.5 &&
                   std::abs(AngleDifference(found->pose.theta(), query.truth.theta())) < 0.1;
    }
    i = (i + 1) % mapped.queries.size();
  }
  state.counters["scored"] = benchmark::Counter(num_scored, benchmark::Counter::kAvgIterations);
  state.counters["found"] = benchmark::Counter(num_found, benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(BM_BranchAndBound, near, NearWindow())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_BranchAndBound, wide, WideWindow())->Unit(benchmark::kMicrosecond);

// From 3 cm and 0.01 rad off the truth, which is what the search leaves over. Counters: iterations per scan and mean
// error of the position.
void BM_Refine(benchmark::State& state) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  size_t i = 0;
  double iterations = 0.0;
  double error = 0.0;
  for (auto _ : state) {
    const Query& query = mapped.queries[i];
    const SE2 initial = query.truth * SE2(0.02, -0.02, 0.01);
    const RefinementResult refined =
        Refine(mapped.target, query.points, initial, query.prediction, MhdOptions(), RefinementOptions());
    iterations += refined.iterations;
    error += (refined.pose.translation() - query.truth.translation()).norm();
    i = (i + 1) % mapped.queries.size();
  }
  state.counters["steps"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
  state.counters["error_mm"] = benchmark::Counter(1e3 * error, benchmark::Counter::kAvgIterations);
}
BENCHMARK(BM_Refine)->Unit(benchmark::kMicrosecond);

// Search and refinement, as the tracker does it for every scan. Counter: share of usable matches.
void BM_Match(benchmark::State& state) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  const Matcher matcher((MatcherOptions()), MhdOptions(), RefinementOptions());
  mapped.target.Pyramid(6);
  const SearchWindow window = NearWindow();
  size_t i = 0;
  double usable = 0.0;
  for (auto _ : state) {
    const Query& query = mapped.queries[i];
    usable += IsUsable(matcher.Match(mapped.target, query.points, query.prediction, window).verdict);
    i = (i + 1) % mapped.queries.size();
  }
  state.counters["usable"] = benchmark::Counter(usable, benchmark::Counter::kAvgIterations);
}
BENCHMARK(BM_Match)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace arborslam
