#include "backend/graph/graph_smoother.h"

#include <ceres/cost_function.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "backend/factors/relative_pose_factor.h"
#include "backend/graph/robust_minimum.h"
#include "backend/graph/robust_solver.h"
#include "backend/graph/rotations_first.h"

namespace arborslam {
namespace {

using Poses = std::vector<Eigen::Vector3d>;

// Of the solve that shows whether all loops agree, and of the last one.
constexpr double kCoarseTolerance = 1e-3;
constexpr int kCoarseIterations = 20;
constexpr double kFineTolerance = 1e-9;
// Loops are searched for anew with a gate that is at most this share of the one before.
constexpr double kFinerGate = 0.5;
// How often loops are searched for and judged anew, at most.
constexpr int kMaxRounds = 10;
// The median norm of three normal variables of variance 1: the square root of chi-square's median.
constexpr double kMedianNorm = 1.5382;
constexpr double kLeastDeviation = 0.1;

// Which things hang together (Tarjan 1975).
class DisjointSets {
 public:
  explicit DisjointSets(size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), size_t{0}); }

  // The least member of the set that `i` is in.
  size_t Find(size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  void Join(size_t i, size_t j) {
    const auto [low, high] = std::minmax({Find(i), Find(j)});
    parent_[high] = low;
  }

 private:
  std::vector<size_t> parent_;
};

// A graph as the solvers want it: vertices by their places in the order of ids.
struct Problem {
  std::vector<int> ids;
  Poses poses;
  std::vector<RelativePose> measurements;
  std::vector<GraphEdge> edges;  // The same; loops may be wrong.
  std::vector<size_t> held;
  size_t num_parts = 0;
  size_t num_loops = 0;
};

Problem MakeProblem(const PoseGraph2& graph) {
  Problem problem;
  for (const auto& [id, pose] : graph.vertices) {
    problem.ids.push_back(id);
    problem.poses.push_back(pose.vector());
  }
  const auto place = [&problem](int id) {
    const auto found = std::lower_bound(problem.ids.begin(), problem.ids.end(), id);
    return static_cast<size_t>(found - problem.ids.begin());
  };
  DisjointSets parts(problem.ids.size());
  problem.measurements.reserve(graph.edges.size());
  problem.edges.reserve(graph.edges.size());
  for (const PoseGraph2::Edge& edge : graph.edges) {
    const size_t from = place(edge.from);
    const size_t to = place(edge.to);
    parts.Join(from, to);
    const bool is_loop = std::max(from, to) - std::min(from, to) > 1;
    problem.num_loops += is_loop ? 1 : 0;
    problem.measurements.push_back({from, to, edge.measurement, edge.information});
    problem.edges.push_back(
        {from, to, std::shared_ptr<ceres::CostFunction>(CreateRelativePoseFactor(edge.measurement, edge.information)),
         is_loop});
  }
  std::vector<bool> has_fixed(problem.ids.size(), false);  // By a part's first vertex.
  for (const int id : graph.fixed) has_fixed[parts.Find(place(id))] = true;
  for (size_t i = 0; i < problem.ids.size(); ++i) {
    const bool is_first = parts.Find(i) == i;
    problem.num_parts += is_first ? 1 : 0;
    if (graph.fixed.count(problem.ids[i]) > 0 || (is_first && !has_fixed[i])) problem.held.push_back(i);
  }
  return problem;
}

std::vector<GraphEdge> WithoutDoubt(std::vector<GraphEdge> edges) {
  for (GraphEdge& edge : edges) edge.may_be_wrong = false;
  return edges;
}

// `given`, or what `measurements` say if `edges` cost less there.
Poses BetterStart(const Poses& given, const std::vector<RelativePose>& measurements,
                  const std::vector<GraphEdge>& edges, const std::vector<size_t>& held, double gate) {
  std::optional<Poses> solved = SolveRotationsFirst(given, measurements, held);
  const bool is_better = solved && CostOf(edges, *solved, gate) < CostOf(edges, given, gate);
  return is_better ? *std::move(solved) : given;
}

// The error [claimed standard deviations] beyond which a loop is wrong at `poses`.
double GateAt(const Poses& poses, const Problem& problem, double loop_gate) {
  std::vector<double> errors;
  for (const GraphEdge& edge : problem.edges) {
    if (edge.may_be_wrong) errors.push_back(ErrorOf(edge, poses));
  }
  if (errors.empty()) return loop_gate;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return loop_gate * std::max(kLeastDeviation, *middle / kMedianNorm);
}

std::vector<bool> WrongAt(const Poses& poses, const Problem& problem, double loop_gate) {
  const double gate = GateAt(poses, problem, loop_gate);
  std::vector<bool> is_wrong;
  is_wrong.reserve(problem.edges.size());
  for (const GraphEdge& edge : problem.edges) is_wrong.push_back(edge.may_be_wrong && ErrorOf(edge, poses) > gate);
  return is_wrong;
}

// Near the minimum of the robust cost, from `agreeing`, where all edges together cost little, and from the edges that
// are not in doubt.
RobustMinimum FindMinimum(const Problem& problem, const SmoothingOptions& options, const Poses& agreeing, double gate,
                          int num_threads) {
  Poses start = problem.poses;
  if (options.rotations_first) {
    std::vector<RelativePose> trusted;
    for (size_t i = 0; i < problem.edges.size(); ++i) {
      if (!problem.edges[i].may_be_wrong) trusted.push_back(problem.measurements[i]);
    }
    start = BetterStart(problem.poses, trusted, problem.edges, problem.held, gate);
  }
  return FindRobustMinimum(start, agreeing, problem.edges, problem.held, gate, num_threads);
}

// A solution without the edges that are left out of it.
struct Solution {
  Poses poses;
  std::vector<bool> is_left_out;
  double chi2 = 0.0;
  int iterations = 0;
};

// Least squares of the edges that are not left out, from the poses as they are.
void SolveWithout(const Problem& problem, int max_iterations, double tolerance, Solution* solution) {
  std::vector<GraphEdge> kept;
  for (size_t i = 0; i < problem.edges.size(); ++i) {
    if (!solution->is_left_out[i]) kept.push_back(problem.edges[i]);
  }
  kept = WithoutDoubt(std::move(kept));
  RobustSolver solver(solution->poses, kept, problem.held);
  solver.Solve(1.0, max_iterations, tolerance);
  solution->poses = solver.poses();
  solution->chi2 = 2.0 * CostOf(kept, solution->poses, 1.0);
  solution->iterations += solver.iterations();
}

// Leaves out what is wrong at the poses, and again where they come to lie without it.
void Settle(const Problem& problem, const PoseGraphOptions& graph_options, Solution* solution) {
  std::vector<bool> is_wrong = WrongAt(solution->poses, problem, graph_options.loop_gate);
  for (int round = 0; round < kMaxRounds && is_wrong != solution->is_left_out; ++round) {
    solution->is_left_out = is_wrong;
    SolveWithout(problem, graph_options.max_iterations, kCoarseTolerance, solution);
    is_wrong = WrongAt(solution->poses, problem, graph_options.loop_gate);
  }
}

// Settles which loops are wrong.
void LeaveOutWrong(const Problem& problem, const SmoothingOptions& options, const PoseGraphOptions& graph_options,
                   int num_threads, Solution* solution) {
  SolveWithout(problem, kCoarseIterations, kCoarseTolerance, solution);
  const Poses agreeing = solution->poses;
  // Wrong loops spoil this solution, and what it says of a standard deviation may be far too great.
  double gate = std::min(graph_options.loop_gate, GateAt(agreeing, problem, graph_options.loop_gate));
  if (LargestLoopError(problem.edges, agreeing) <= gate) return;
  for (int search = 0; search < kMaxRounds; ++search) {
    RobustMinimum minimum = FindMinimum(problem, options, agreeing, gate, num_threads);
    Solution found{std::move(minimum.poses), std::vector<bool>(problem.edges.size(), false), 0.0,
                   solution->iterations + minimum.iterations};
    Settle(problem, graph_options, &found);
    const bool is_lower =
        search == 0 || CostOf(problem.edges, found.poses, gate) < CostOf(problem.edges, solution->poses, gate);
    solution->iterations = found.iterations;
    if (!is_lower) break;
    *solution = std::move(found);
    // Without most of the wrong loops it is known better what a standard deviation is: by a gate that is too great,
    // bending the path to a wrong loop may cost less than the loop.
    const double finer = GateAt(solution->poses, problem, graph_options.loop_gate);
    if (finer > kFinerGate * gate) break;
    gate = finer;
  }
}

}  // namespace

std::string SmoothingOptions::Validate() const { return ""; }

SmoothedGraph SmoothGraph(const PoseGraph2& graph, const SmoothingOptions& options,
                          const PoseGraphOptions& graph_options, int num_threads) {
  const Problem problem = MakeProblem(graph);
  SmoothedGraph result;
  result.num_parts = problem.num_parts;
  result.num_loops = problem.num_loops;
  for (const size_t i : problem.held) result.held.push_back(problem.ids[i]);

  const std::vector<GraphEdge> all = WithoutDoubt(problem.edges);
  result.initial_chi2 = 2.0 * CostOf(all, problem.poses, 1.0);
  Solution solution;
  solution.poses = problem.poses;
  solution.is_left_out.assign(all.size(), false);
  if (options.rotations_first) {
    solution.poses = BetterStart(problem.poses, problem.measurements, all, problem.held, 1.0);
  }
  result.started_from_edges = solution.poses != problem.poses;
  if (options.robust) LeaveOutWrong(problem, options, graph_options, num_threads, &solution);
  SolveWithout(problem, graph_options.max_iterations, kFineTolerance, &solution);

  result.final_chi2 = solution.chi2;
  result.iterations = solution.iterations;
  result.graph.fixed = graph.fixed;
  for (size_t i = 0; i < graph.edges.size(); ++i) {
    (solution.is_left_out[i] ? result.dropped_loops : result.graph.edges).push_back(graph.edges[i]);
  }
  for (size_t i = 0; i < problem.ids.size(); ++i) {
    const Eigen::Vector3d& pose = solution.poses[i];
    result.graph.vertices.emplace(problem.ids[i], SE2(pose.x(), pose.y(), pose.z()));
  }
  return result;
}

}  // namespace arborslam
