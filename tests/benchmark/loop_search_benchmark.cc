// What it costs to find a keyframe again in an area with two hundred stored submaps.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <ctime>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/loop/loop_closer.h"
#include "backend/loop/place_recognizer.h"
#include "backend/loop/submap_targets.h"
#include "backend/slam_options.h"
#include "core/map/submap.h"
#include "tests/benchmark/simulated_run.h"

namespace arborslam {
namespace {

constexpr int kNumSubmaps = 200;
constexpr int kSubmapStep = 30;    // Keyframes from the beginning of one submap to that of the next,
constexpr int kSubmapLength = 60;  // and in a submap.

// A robot that goes around one orchard again and again, at its true poses; the last keyframes are in no submap.
struct MuchVisitedArea {
  PoseGraph graph;
  std::vector<Keyframe> keyframes;
  std::vector<Submap> submaps;

  MuchVisitedArea() {
    const SlamOptions options;
    const int num_scans = kNumSubmaps * kSubmapStep + kSubmapLength;
    const PlanarOrchard orchard = BenchmarkOrchard(num_scans);
    for (int i = 0; i < num_scans; ++i) {
      const auto index = static_cast<size_t>(i);
      keyframes.push_back({KeyframeId{i}, ProjectLaserScan(orchard.Scan(index), options.projection), true});
      graph.AddNode(KeyframeId{i}, orchard.TruePose(index));
    }
    const Eigen::Matrix3d information = Eigen::Vector3d(1e4, 1e4, 1e5).asDiagonal();
    for (int s = 0; s < kNumSubmaps; ++s) {
      Submap submap;
      submap.id = SubmapId{s};
      const SE2 T_map_submap = graph.Pose(KeyframeId{s * kSubmapStep});
      graph.AddNode(submap.id, T_map_submap);
      OccupancyGrid grid(options.grid);
      for (int i = s * kSubmapStep; i < s * kSubmapStep + kSubmapLength; ++i) {
        const SE2 T_submap_keyframe = T_map_submap.Inverse() * graph.Pose(KeyframeId{i});
        grid.Insert(T_submap_keyframe, *keyframes[static_cast<size_t>(i)].scan.Get());
        submap.keyframes.push_back(KeyframeId{i});
        graph.AddConstraint({submap.id, KeyframeId{i}, T_submap_keyframe, information, Constraint::Kind::kSubmap});
      }
      submap.cells = grid.OccupiedCells(static_cast<float>(LogOddsOf(options.tracker.min_occupancy)));
      submaps.push_back(submap);
    }
  }
};

const MuchVisitedArea& SharedArea() {
  static const MuchVisitedArea* const area = new MuchVisitedArea();
  return *area;
}

Matcher DefaultMatcher() {
  const SlamOptions options;
  return Matcher(options.matcher, options.mhd, options.refinement);
}

// [s] of processor time, which other programs do not lengthen.
double ProcessorTime() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The search of a whole run, on one thread. Counters: keyframes tried, milliseconds for each of them, share of the
// pairs that were accepted.
void BM_LoopSearch(benchmark::State& state) {
  const MuchVisitedArea& area = SharedArea();
  const SlamOptions options;
  const LoopCloser closer(options.loop, options.matcher, DefaultMatcher(), options.grid);
  double seconds = 0.0;
  double num_keyframes = 0.0;
  double num_tried = 0.0;
  double num_accepted = 0.0;
  for (auto _ : state) {
    const double begin = ProcessorTime();
    const std::vector<LoopCandidate> loops =
        closer.FindAll(area.graph, area.graph, area.keyframes, area.submaps, {}, 1);
    seconds += ProcessorTime() - begin;
    std::vector<int> keyframes;
    for (const LoopCandidate& loop : loops) {
      keyframes.push_back(loop.keyframe.value);
      num_accepted += loop.accepted ? 1.0 : 0.0;
    }
    num_tried += static_cast<double>(loops.size());
    std::sort(keyframes.begin(), keyframes.end());
    num_keyframes += static_cast<double>(std::unique(keyframes.begin(), keyframes.end()) - keyframes.begin());
  }
  state.counters["keyframes"] = num_keyframes / static_cast<double>(state.iterations());
  state.counters["ms_per_keyframe"] = 1e3 * seconds / num_keyframes;
  state.counters["accepted"] = num_accepted / num_tried;
}
BENCHMARK(BM_LoopSearch)->Unit(benchmark::kMillisecond)->Iterations(1);

// One keyframe without any prior. Counters: the median [ms], and the share of the keyframes that were recognised.
void BM_PlaceRecognition(benchmark::State& state) {
  const MuchVisitedArea& area = SharedArea();
  const SlamOptions options;
  const PlaceRecognizer recognizer(PlaceOptions(), DefaultMatcher(), options.matcher.max_second_ratio, area.graph,
                                   area.keyframes, area.submaps);
  SubmapTargets targets(area.submaps, options.grid.cell_size, options.matcher.max_distance, 8);
  std::vector<double> milliseconds;
  double num_recognized = 0.0;
  size_t next = 0;
  for (auto _ : state) {
    const double begin = ProcessorTime();
    const PlaceRecognition found = recognizer.Recognize(area.keyframes[next].scan.Get()->points, &targets);
    milliseconds.push_back(1e3 * (ProcessorTime() - begin));
    num_recognized += found.best ? 1.0 : 0.0;
    next = (next + 4) % area.keyframes.size();
  }
  const auto middle = milliseconds.begin() + static_cast<std::ptrdiff_t>(milliseconds.size() / 2);
  std::nth_element(milliseconds.begin(), middle, milliseconds.end());
  state.counters["median_ms"] = *middle;
  state.counters["recognised"] = num_recognized / static_cast<double>(milliseconds.size());
}
BENCHMARK(BM_PlaceRecognition)->Unit(benchmark::kMillisecond)->Iterations(200);

}  // namespace
}  // namespace arborslam
