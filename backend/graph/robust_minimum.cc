#include "backend/graph/robust_minimum.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"

namespace arborslam {
namespace {

// Of the solves on the way. Growing goes on while few loops at a time come to fit.
constexpr double kGrowingTolerance = 1e-5;
constexpr double kShrinkingTolerance = 1e-3;
constexpr int kCoarseIterations = 20;
// How much one solve's scale differs from that of the one before. Few and large steps of shrinking do (Yang et al. take
// 1.4): what a solve costs is less its iterations than Ceres' analysis of the graph.
constexpr double kGrowth = 4.0;
constexpr double kShrinkage = 16.0;

void SolveGrowing(double gate, RobustSolver* solver) {
  solver->Solve(gate / kGrowth, kCoarseIterations, kGrowingTolerance);
  solver->Solve(gate, kCoarseIterations, kGrowingTolerance);
}

void SolveShrinking(double gate, const std::vector<GraphEdge>& edges, RobustSolver* solver) {
  // At sqrt(2) times the largest error, the cost of all loops is nearly quadratic (Yang et al. 2020, remark 5).
  double scale = std::sqrt(2.0) * LargestLoopError(edges, solver->poses());
  while (scale > gate) {
    solver->Solve(scale, 1, kShrinkingTolerance);
    scale = std::min(scale / kShrinkage, std::sqrt(2.0) * LargestLoopError(edges, solver->poses()));
  }
  solver->Solve(gate, kCoarseIterations, kShrinkingTolerance);
}

}  // namespace

double LargestLoopError(const std::vector<GraphEdge>& edges, const std::vector<Eigen::Vector3d>& poses) {
  double largest = 0.0;
  for (const GraphEdge& edge : edges) {
    if (edge.may_be_wrong) largest = std::max(largest, ErrorOf(edge, poses));
  }
  return largest;
}

RobustMinimum FindRobustMinimum(const std::vector<Eigen::Vector3d>& growing_start,
                                const std::vector<Eigen::Vector3d>& shrinking_start,
                                const std::vector<GraphEdge>& edges, const std::vector<size_t>& held, double gate,
                                int num_threads) {
  std::optional<RobustSolver> growing;
  std::optional<RobustSolver> shrinking;
  const auto grow = [&] { SolveGrowing(gate, &growing.emplace(growing_start, edges, held)); };
  const auto shrink = [&] { SolveShrinking(gate, edges, &shrinking.emplace(shrinking_start, edges, held)); };
  const auto all_fit = [&] { return LargestLoopError(edges, growing->poses()) <= gate; };
  if (num_threads < 2) {
    grow();
    if (!all_fit()) shrink();
  } else {
    ParallelFor(2, 2, [&](size_t i) { i == 0 ? grow() : shrink(); });
  }
  if (all_fit()) return {growing->poses(), growing->iterations()};
  const RobustSolver& lower = shrinking->final_cost() < growing->final_cost() ? *shrinking : *growing;
  return {lower.poses(), growing->iterations() + shrinking->iterations()};
}

}  // namespace arborslam
