// What it costs to estimate poses from measurements: one keyframe in the window, and a whole graph.

#include <benchmark/benchmark.h>

#include <memory>

#include "backend/graph/pose_graph.h"
#include "backend/slam_options.h"
#include "backend/window/sliding_window.h"
#include "tests/benchmark/simulated_run.h"

namespace arborslam {
namespace {

constexpr int kNumKeyframes = 1000;

const MeasuredRun& SharedMeasuredRun() {
  static const MeasuredRun* const run = new MeasuredRun(MeasuredRun::Simulate(kNumKeyframes));
  return *run;
}

// A window on its way along a run.
class WindowRun {
 public:
  // A full window.
  explicit WindowRun(const MeasuredRun& run) : run_(run) {
    while (next_ < WindowOptions().num_keyframes) Advance();
  }

  bool AtEnd() const { return next_ == kNumKeyframes; }
  double Error() const {
    const KeyframeId last{next_ - 1};
    return (window_.Pose(last).translation() - run_.keyframes[static_cast<size_t>(last.value)].translation()).norm();
  }

  // One more keyframe with its measurements; the oldest keyframe and submap leave.
  void Advance() {
    const KeyframeId id{next_};
    const auto& constraints = run_.constraints[static_cast<size_t>(next_)];
    if (next_ == 0) {
      window_.AddNode(id, run_.keyframes.front());
      window_.AddPrior(id, 1e8 * Eigen::Matrix3d::Identity());
    } else {
      window_.AddNode(id, window_.Pose(constraints.front().from) * constraints.front().T_from_to);
    }
    const bool begins_submap = next_ % MeasuredRun::kSubmapInterval == 0;
    const int submap = next_ / MeasuredRun::kSubmapInterval;
    if (begins_submap) window_.AddNode(SubmapId{submap}, window_.Pose(id));
    for (const Constraint& constraint : constraints) window_.AddConstraint(constraint);
    window_.Solve();
    const int oldest = next_ - WindowOptions().num_keyframes;
    if (oldest >= 0) window_.Marginalize(KeyframeId{oldest});
    if (begins_submap && submap >= 2) window_.Marginalize(SubmapId{submap - 2});
    ++next_;
  }

 private:
  const MeasuredRun& run_;
  SlidingWindow window_;
  int next_ = 0;
};

// Solve and marginalisation for one keyframe in a full window of default size. Counter: the error in position at the
// end of the last whole run, or of the first window.
void BM_WindowUpdate(benchmark::State& state) {
  auto window = std::make_unique<WindowRun>(SharedMeasuredRun());
  double error = window->Error();
  for (auto _ : state) {
    if (window->AtEnd()) {
      state.PauseTiming();
      error = window->Error();
      window = std::make_unique<WindowRun>(SharedMeasuredRun());
      state.ResumeTiming();
    }
    window->Advance();
  }
  state.counters["error_mm"] = 1e3 * error;
}
BENCHMARK(BM_WindowUpdate)->Unit(benchmark::kMicrosecond);

// A thousand keyframes from dead reckoning, twice around the orchard, with a loop from every fourth keyframe of the
// second lap to a submap of the first. Argument: threads. Counters: loops, mean errors in position before and after.
void BM_GraphOptimize(benchmark::State& state) {
  const MeasuredRun& run = SharedMeasuredRun();
  const int lap = static_cast<int>(BenchmarkOrchard(0).NumScans());
  PoseGraph graph;
  Random random(3);
  int num_loops = 0;
  for (int k = 0; k < kNumKeyframes; ++k) {
    const KeyframeId id{k};
    const auto& constraints = run.constraints[static_cast<size_t>(k)];
    const Constraint& motion = constraints.front();
    graph.AddNode(id, k == 0 ? run.keyframes.front() : graph.Pose(motion.from) * motion.T_from_to);
    if (k % MeasuredRun::kSubmapInterval == 0) {
      graph.AddNode(SubmapId{k / MeasuredRun::kSubmapInterval}, graph.Pose(id));
    }
    for (const Constraint& constraint : constraints) graph.AddConstraint(constraint);
    if (k < lap || k % 4 != 0) continue;
    const SubmapId submap{(k - lap) / MeasuredRun::kSubmapInterval};
    graph.AddConstraint(MeasuredRun::Measure(submap, run.submaps[static_cast<size_t>(submap.value)], id,
                                             run.keyframes[static_cast<size_t>(k)], {0.02, 0.005},
                                             Constraint::Kind::kLoop, &random));
    ++num_loops;
  }
  const auto mean_error = [&run](const PoseGraph& estimate) {
    double sum = 0.0;
    for (int k = 0; k < kNumKeyframes; ++k) {
      sum += (estimate.Pose(KeyframeId{k}).translation() - run.keyframes[static_cast<size_t>(k)].translation()).norm();
    }
    return sum / kNumKeyframes;
  };
  PoseGraph optimized;
  for (auto _ : state) {
    state.PauseTiming();
    optimized = graph;
    state.ResumeTiming();
    optimized.Optimize(PoseGraphOptions(), static_cast<int>(state.range(0)));
  }
  state.counters["loops"] = num_loops;
  state.counters["before_mm"] = 1e3 * mean_error(graph);
  state.counters["after_mm"] = 1e3 * mean_error(optimized);
}
BENCHMARK(BM_GraphOptimize)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace arborslam
