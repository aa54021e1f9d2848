// What it costs to keep a map and to make it ready for matching.

#include <benchmark/benchmark.h>

#include <vector>

#include "core/map/distance_field.h"
#include "core/map/min_pyramid.h"
#include "core/map/occupancy_grid.h"
#include "frontend/matching/match_target.h"
#include "tests/benchmark/simulated_run.h"

namespace arborslam {
namespace {

// One scan into a grown grid: of a lidar in the plane, whose rays to the points are free, or of a sweep in space, which
// knows in every direction how far it is free.
void BM_GridInsert(benchmark::State& state, bool in_space) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  OccupancyGrid grid((OccupancyGridOptions()));
  std::vector<PlanarScan> scans = mapped.scans;
  size_t num_rays = 0;
  for (PlanarScan& scan : scans) {
    num_rays += scan.points.size() + scan.free_ends.size();
    if (!in_space) continue;
    scan.point_rays_are_free = false;
    for (const Eigen::Vector2f& point : scan.points) scan.free_ends.push_back(0.97f * point);
  }
  for (size_t k = 0; k < scans.size(); ++k) grid.Insert(mapped.poses[k], scans[k]);
  size_t i = 0;
  for (auto _ : state) {
    grid.Insert(mapped.poses[i], scans[i]);
    i = (i + 1) % scans.size();
  }
  state.counters["rays"] = static_cast<double>(num_rays) / static_cast<double>(scans.size());
}
BENCHMARK_CAPTURE(BM_GridInsert, planar, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_GridInsert, sweep, true)->Unit(benchmark::kMicrosecond);

// All scans into a new grid, growth included.
void BM_GridBuild(benchmark::State& state) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  for (auto _ : state) {
    OccupancyGrid grid((OccupancyGridOptions()));
    for (size_t i = 0; i < mapped.scans.size(); ++i) grid.Insert(mapped.poses[i], mapped.scans[i]);
    benchmark::DoNotOptimize(grid);
  }
  state.counters["scans"] = static_cast<double>(mapped.scans.size());
}
BENCHMARK(BM_GridBuild)->Unit(benchmark::kMillisecond);

void BM_OccupiedCells(benchmark::State& state) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  for (auto _ : state) benchmark::DoNotOptimize(mapped.grid.OccupiedCells(0.0f));
  state.counters["occupied"] = static_cast<double>(mapped.grid.OccupiedCells(0.0f).size());
}
BENCHMARK(BM_OccupiedCells)->Unit(benchmark::kMicrosecond);

void BM_DistanceField(benchmark::State& state, DistanceMetric metric) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  const double max_distance = mapped.target.field().max_distance();
  std::vector<Eigen::Vector2f> points;
  for (const OccupiedCell& cell : mapped.cells) points.push_back(cell.centroid);
  for (auto _ : state) {
    benchmark::DoNotOptimize(DistanceField(points, mapped.grid.cell_size(), max_distance, metric));
  }
  const DistanceField& field = mapped.target.field();
  state.counters["occupied"] = static_cast<double>(points.size());
  state.counters["cells"] = static_cast<double>(field.width()) * field.height();
}
BENCHMARK_CAPTURE(BM_DistanceField, L1, DistanceMetric::kL1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_DistanceField, L2, DistanceMetric::kL2)->Unit(benchmark::kMicrosecond);

// Argument: levels. The tracker's small window takes 4, its wide one 5.
void BM_MinPyramid(benchmark::State& state) {
  const DistanceField& field = SharedMappedOrchard().target.field();
  for (auto _ : state) benchmark::DoNotOptimize(MinPyramid(field, static_cast<int>(state.range(0))));
}
BENCHMARK(BM_MinPyramid)->Arg(4)->Arg(5)->Unit(benchmark::kMicrosecond);

// Landmarks with their shapes and the distance field, without the pyramid.
void BM_MatchTarget(benchmark::State& state) {
  const MappedOrchard& mapped = SharedMappedOrchard();
  const double max_distance = mapped.target.field().max_distance();
  for (auto _ : state) benchmark::DoNotOptimize(MatchTarget(mapped.cells, mapped.grid.cell_size(), max_distance));
}
BENCHMARK(BM_MatchTarget)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace arborslam
