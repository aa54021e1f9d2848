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

// What `Slam` does with keyframes' measurements: window and graph.
class LongRun {
 public:
  // `run` must outlive this.
  explicit LongRun(const OrchardGraph& run) : run_(run) {}

  // Takes the next keyframe; returns the time [ms] that it took.
  double Advance() {
    const double begin = ProcessorTime();
    const int k = next_++;
    const KeyframeId id{k};
    // A keyframe's first edge is its motion.
    const SE2 initial = k == 0 ? run_.truth[0] : window_.Pose(KeyframeId{k - 1}) * run_.graph.edges[edge_].measurement;
    window_.AddNode(id, initial);
    graph_.AddNode(id, initial);
    if (k == 0) window_.AddPrior(id, 1e8 * Eigen::Matrix3d::Identity());
    if (k % kSubmapInterval == 0) {
      window_.AddNode(SubmapId{k / kSubmapInterval}, initial);
      graph_.AddNode(SubmapId{k / kSubmapInterval}, initial);
    }
    for (; edge_ < run_.first_loop && run_.graph.edges[edge_].to == k; ++edge_) {
      const Constraint constraint = ConstraintOf(edge_, run_);
      window_.AddConstraint(constraint);
      graph_.AddConstraint(constraint);
    }
    window_.Solve();
    for (const auto& [node, pose] : window_.poses()) graph_.SetPose(node, pose);
    const KeyframeId too_old{k - WindowOptions().num_keyframes};
    if (window_.Has(too_old)) window_.Marginalize(too_old);
    const SubmapId finished{k / kSubmapInterval - 2};
    if (k % kSubmapInterval == 0 && window_.Has(finished)) window_.Marginalize(finished);
    return ProcessorTime() - begin;
  }

 private:
  static constexpr int kSubmapInterval = 50;

  const OrchardGraph& run_;
  SlidingWindow window_;
  PoseGraph graph_;
  size_t edge_ = 0;
  int next_ = 0;
};

// A keyframe early and late in a run of 50,000. Counters: medians over the thousand keyframes from the 100th and over
// the last thousand, taken by turns, so that both meet the machine in the same state; and their ratio.
void BM_KeyframeOfALongRun(benchmark::State& state) {
  constexpr int kNumKeyframes = 50000;
  constexpr int kNumTimed = 1000;
  constexpr int kFirstTimed = 100;
  const OrchardGraph run = SimulateKeyframes(kNumKeyframes);
  std::vector<double> early;
  std::vector<double> late;
  for (auto _ : state) {
    early.clear();
    late.clear();
    LongRun young(run);
    LongRun old(run);
    for (int k = 0; k < kFirstTimed; ++k) young.Advance();
    for (int k = 0; k < kNumKeyframes - kNumTimed; ++k) old.Advance();
    for (int k = 0; k < kNumTimed; ++k) {
      early.push_back(young.Advance());
      late.push_back(old.Advance());
    }
  }
  state.counters["early_ms"] = Median(early);
  state.counters["late_ms"] = Median(late);
  state.counters["ratio"] = Median(late) / Median(early);
}
BENCHMARK(BM_KeyframeOfALongRun)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace arborslam
