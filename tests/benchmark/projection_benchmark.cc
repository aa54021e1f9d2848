// What it costs to reduce a sweep to a planar scan, stage by stage: a VLP-16 in a citrus grove, about 30,000 returns.

#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "core/simulation/citrus.h"
#include "core/simulation/simulated_run.h"
#include "frontend/projection/canopy_height.h"
#include "frontend/projection/deskew.h"
#include "frontend/projection/ground_fit.h"
#include "frontend/projection/ground_model.h"
#include "frontend/projection/lowest_returns.h"
#include "frontend/projection/sweep_projector.h"
#include "frontend/projection/sweep_timing.h"

namespace arborslam {
namespace {

const SweepMotion kMotion{{1.0f, 0.1f, 0.0f}, {0.1f, 0.2f, 0.4f}};

// Sweeps well inside the grove, without times.
const std::vector<LidarSweep>& SharedSweeps() {
  static const std::vector<LidarSweep>* const sweeps = [] {
    CitrusOptions options;
    options.run.lidar.columns = 2100;
    const SimulatedRun run(options.run, MakeCitrus(options));
    auto* const made = new std::vector<LidarSweep>;
    for (size_t i = 0; i < 8; ++i) {
      made->push_back(run.Sweep(run.NumScans() / 3 + 10 * i));
      made->back().times.clear();
    }
    return made;
  }();
  return *sweeps;
}

// Calls `stage` with one sweep after the other.
template <class Stage>
void Run(benchmark::State& state, const Stage& stage) {
  const std::vector<LidarSweep>& sweeps = SharedSweeps();
  double num_points = 0.0;
  size_t i = 0;
  for (auto _ : state) {
    const LidarSweep& sweep = sweeps[i++ % sweeps.size()];
    num_points += static_cast<double>(sweep.points.size());
    stage(sweep);
  }
  state.counters["returns"] = benchmark::Counter(num_points, benchmark::Counter::kAvgIterations);
}

void BM_PointPhases(benchmark::State& state) {
  std::vector<float> phases;
  Run(state, [&](const LidarSweep& sweep) {
    PointPhases(sweep, &phases);
    benchmark::DoNotOptimize(phases.data());
  });
}
BENCHMARK(BM_PointPhases)->Unit(benchmark::kMicrosecond);

void BM_Deskew(benchmark::State& state) {
  std::vector<std::vector<float>> phases;
  for (const LidarSweep& sweep : SharedSweeps()) phases.push_back(PointPhases(sweep));
  std::vector<Eigen::Vector3f> points;
  size_t i = 0;
  Run(state, [&](const LidarSweep& sweep) {
    Deskew(sweep, phases[i++ % phases.size()], kMotion, &points);
    benchmark::DoNotOptimize(points.data());
  });
}
BENCHMARK(BM_Deskew)->Unit(benchmark::kMicrosecond);

void BM_LowestReturns(benchmark::State& state) {
  LowestReturns lowest(0.5f, 0.5f, GroundModel::kReach);
  Run(state, [&](const LidarSweep& sweep) {
    benchmark::DoNotOptimize(lowest.Find(sweep.points, Eigen::Vector3f::UnitZ()).data());
  });
}
BENCHMARK(BM_LowestReturns)->Unit(benchmark::kMicrosecond);

void BM_FitGround(benchmark::State& state, bool with_prior) {
  LowestReturns lowest(0.5f, 0.5f, GroundModel::kReach);
  GroundFit prior;
  int num_found = 0;
  int num_fits = 0;
  Run(state, [&](const LidarSweep& sweep) {
    state.PauseTiming();
    lowest.Find(sweep.points, Eigen::Vector3f::UnitZ());
    state.ResumeTiming();
    const GroundFit fit = FitGround(lowest.returns(), prior);
    if (with_prior) prior = fit;
    num_found += fit.ok ? 1 : 0;
    ++num_fits;
  });
  state.counters["found"] = static_cast<double>(num_found) / num_fits;
}
BENCHMARK_CAPTURE(BM_FitGround, with_prior, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_FitGround, without_prior, false)->Unit(benchmark::kMicrosecond);

void BM_GroundModel(benchmark::State& state) {
  LowestReturns lowest(0.5f, 0.5f, GroundModel::kReach);
  std::vector<std::vector<Eigen::Vector3f>> returns;
  std::vector<GroundFit> fits;
  for (const LidarSweep& sweep : SharedSweeps()) {
    returns.push_back(lowest.Find(sweep.points, Eigen::Vector3f::UnitZ()));
    fits.push_back(FitGround(returns.back(), GroundFit()));
  }
  GroundModel model;
  std::vector<float> heights;
  size_t i = 0;
  Run(state, [&](const LidarSweep& sweep) {
    model.Build(returns[i % returns.size()], fits[i % returns.size()]);
    model.Measure(sweep.points, &heights);
    ++i;
  });
}
BENCHMARK(BM_GroundModel)->Unit(benchmark::kMicrosecond);

void BM_CanopyHeight(benchmark::State& state) {
  SweepProjector projector((SweepProjectionOptions()));
  std::vector<PreparedSweep> prepared;
  for (const LidarSweep& sweep : SharedSweeps()) prepared.push_back(projector.Prepare(sweep, kMotion));
  CanopyHeight canopy;
  size_t i = 0;
  Run(state, [&](const LidarSweep&) {
    const PreparedSweep& sweep = prepared[i++ % prepared.size()];
    canopy.Add(sweep.points, sweep.heights);
    benchmark::DoNotOptimize(canopy.Get());
  });
}
BENCHMARK(BM_CanopyHeight)->Unit(benchmark::kMicrosecond);

void BM_Prepare(benchmark::State& state) {
  SweepProjector projector((SweepProjectionOptions()));
  PreparedSweep prepared;
  Run(state, [&](const LidarSweep& sweep) { prepared = projector.Prepare(sweep, kMotion, std::move(prepared)); });
}
BENCHMARK(BM_Prepare)->Unit(benchmark::kMicrosecond);

void BM_Project(benchmark::State& state) {
  SweepProjector projector((SweepProjectionOptions()));
  std::vector<PreparedSweep> prepared;
  for (const LidarSweep& sweep : SharedSweeps()) prepared.push_back(projector.Prepare(sweep, kMotion));
  double num_points = 0.0;
  size_t i = 0;
  Run(state, [&](const LidarSweep&) {
    const PreparedSweep& sweep = prepared[i++ % prepared.size()];
    num_points += static_cast<double>(projector.Project(sweep, LevelRotation(sweep.ground.normal)).points.size());
  });
  state.counters["points"] = benchmark::Counter(num_points, benchmark::Counter::kAvgIterations);
}
BENCHMARK(BM_Project)->Unit(benchmark::kMicrosecond);

// All of it.
void BM_ReduceSweep(benchmark::State& state) {
  SweepProjector projector((SweepProjectionOptions()));
  PreparedSweep prepared;
  Run(state, [&](const LidarSweep& sweep) {
    prepared = projector.Prepare(sweep, kMotion, std::move(prepared));
    benchmark::DoNotOptimize(projector.Project(prepared, LevelRotation(prepared.ground.normal)));
  });
}
BENCHMARK(BM_ReduceSweep)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace arborslam
