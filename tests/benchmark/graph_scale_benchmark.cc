// What long runs cost: a whole graph of up to 100,000 keyframes, and one keyframe early and late in a run.

#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/slam_options.h"
#include "backend/window/sliding_window.h"
#include "core/simulation/orchard_graph.h"

namespace arborslam {
namespace {

OrchardGraph SimulateKeyframes(int num_keyframes) {
  OrchardGraphOptions options;
  options.num_keyframes = num_keyframes;
  return SimulateOrchardGraph(options);
}

NodeId NodeOf(int vertex, const OrchardGraph& run) {
  const int num_keyframes = static_cast<int>(run.num_keyframes);
  if (vertex < num_keyframes) return KeyframeId{vertex};
  return SubmapId{vertex - num_keyframes};
}

Constraint ConstraintOf(size_t edge_index, const OrchardGraph& run) {
  const PoseGraph2::Edge& edge = run.graph.edges[edge_index];
  const NodeId from = NodeOf(edge.from, run);
  const Constraint::Kind kind = edge_index >= run.first_loop           ? Constraint::Kind::kLoop
                                : from.kind == NodeId::Kind::kKeyframe ? Constraint::Kind::kMotion
                                                                       : Constraint::Kind::kSubmap;
  return {from, NodeOf(edge.to, run), edge.measurement, edge.information, kind};
}

double Rmse(const PoseGraph& graph, const OrchardGraph& run) {
  double sum = 0.0;
  for (size_t k = 0; k < run.num_keyframes; ++k) {
    const SE2& pose = graph.Pose(KeyframeId{static_cast<int>(k)});
    sum += (pose.translation() - run.truth[k].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(run.num_keyframes));
}

// [MiB], the most that the process has had: sizes come in ascending order, so that it is the present one's.
double PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// The optimisation of a whole orchard graph on one thread. Argument: keyframes. Counters: edges, loops, errors in
// position against the truth in the frame of the first pose, and memory.
void BM_OrchardGraph(benchmark::State& state) {
  const OrchardGraph run = SimulateKeyframes(static_cast<int>(state.range(0)));
  PoseGraph graph;
  for (const auto& [vertex, pose] : run.graph.vertices) graph.AddNode(NodeOf(vertex, run), pose);
  for (size_t i = 0; i < run.graph.edges.size(); ++i) graph.AddConstraint(ConstraintOf(i, run));
  const double before = Rmse(graph, run);
  size_t num_dropped = 0;
  for (auto _ : state) num_dropped = graph.Optimize(PoseGraphOptions(), 1).dropped_loops.size();
  state.counters["edges"] = static_cast<double>(run.graph.edges.size());
  state.counters["loops"] = static_cast<double>(run.graph.edges.size() - run.first_loop);
  state.counters["dropped"] = static_cast<double>(num_dropped);
  state.counters["before_m"] = before;
  state.counters["after_m"] = Rmse(graph, run);
  state.counters["peak_mib"] = PeakMemory();
}
BENCHMARK(BM_OrchardGraph)
    ->Arg(1000)
    ->Arg(3000)
    ->Arg(10000)
    ->Arg(30000)
    ->Arg(100000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

// [ms], that this thread has had of the processor: what else the machine does must not look like growth.
double ProcessorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// What `Slam` does with a keyframe's measurements, over a run of 50,000: window and graph. Counters: medians of the
// thousand keyframes from the 100th and of the last thousand, and their ratio.
void BM_KeyframeOfALongRun(benchmark::State& state) {
  constexpr int kNumKeyframes = 50000;
  constexpr int kSubmapInterval = 50;
  const OrchardGraph run = SimulateKeyframes(kNumKeyframes);
  std::vector<double> times;
  for (auto _ : state) {
    SlidingWindow window;
    PoseGraph graph;
    times.clear();
    size_t edge = 0;
    for (int k = 0; k < kNumKeyframes; ++k) {
      const KeyframeId id{k};
      const double begin = ProcessorTime();
      // A keyframe's first edge is its motion.
      const SE2 initial = k == 0 ? run.truth[0] : window.Pose(KeyframeId{k - 1}) * run.graph.edges[edge].measurement;
      window.AddNode(id, initial);
      graph.AddNode(id, initial);
      if (k == 0) window.AddPrior(id, 1e8 * Eigen::Matrix3d::Identity());
      if (k % kSubmapInterval == 0) {
        window.AddNode(SubmapId{k / kSubmapInterval}, initial);
        graph.AddNode(SubmapId{k / kSubmapInterval}, initial);
      }
      for (; edge < run.first_loop && run.graph.edges[edge].to == k; ++edge) {
        const Constraint constraint = ConstraintOf(edge, run);
        window.AddConstraint(constraint);
        graph.AddConstraint(constraint);
      }
      window.Solve();
      for (const auto& [node, pose] : window.poses()) graph.SetPose(node, pose);
      const KeyframeId too_old{k - WindowOptions().num_keyframes};
      if (window.Has(too_old)) window.Marginalize(too_old);
      const SubmapId finished{k / kSubmapInterval - 2};
      if (k % kSubmapInterval == 0 && window.Has(finished)) window.Marginalize(finished);
      times.push_back(ProcessorTime() - begin);
    }
  }
  const double early = Median({times.begin() + 100, times.begin() + 1100});
  const double late = Median({times.end() - 1000, times.end()});
  state.counters["early_ms"] = early;
  state.counters["late_ms"] = late;
  state.counters["ratio"] = late / early;
}
BENCHMARK(BM_KeyframeOfALongRun)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace arborslam
