#include "backend/graph/robust_solver.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>
#ifdef ARBORSLAM_HAS_OPENMP
#include <omp.h>
#endif

#include <cmath>
#include <limits>
#include <string>

namespace arborslam {
namespace {

class GemanMcClureLoss : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double scale) : squared_scale_(scale * scale) {}

  void Evaluate(double squared_error, double rho[3]) const override {
    // rho(r^2) = s^2 r^2 / (s^2 + r^2) and its derivatives by r^2.
    const double sum = squared_scale_ + squared_error;
    const double ratio = squared_scale_ / sum;
    rho[0] = ratio * squared_error;
    rho[1] = ratio * ratio;
    rho[2] = -2.0 * ratio * ratio / sum;
  }

 private:
  double squared_scale_;
};

// While it lives, OpenMP has no more than the calling thread here. CHOLMOD may have been built to start several
// whatever Ceres is told, which wait for each other by spinning: many small factorisations take longer, and on a busy
// machine several times as long.
class OneOpenMpThread {
 public:
#ifdef ARBORSLAM_HAS_OPENMP
  OneOpenMpThread() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~OneOpenMpThread() { omp_set_max_active_levels(levels_); }
  OneOpenMpThread(const OneOpenMpThread&) = delete;
  OneOpenMpThread& operator=(const OneOpenMpThread&) = delete;

 private:
  int levels_;
#endif
};

ceres::Problem::Options OwnNothing() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

}  // namespace

double ErrorOf(const GraphEdge& edge, const std::vector<Eigen::Vector3d>& poses) {
  Eigen::Vector3d residuals;
  const double* parameters[] = {poses[edge.from].data(), poses[edge.to].data()};
  edge.factor->Evaluate(parameters, residuals.data(), nullptr);
  return residuals.norm();
}

double CostOf(const std::vector<GraphEdge>& edges, const std::vector<Eigen::Vector3d>& poses, double scale) {
  const GemanMcClureLoss loss(scale);
  double sum = 0.0;
  for (const GraphEdge& edge : edges) {
    const double squared_error = std::pow(ErrorOf(edge, poses), 2);
    double rho[3] = {squared_error, 1.0, 0.0};
    if (edge.may_be_wrong) loss.Evaluate(squared_error, rho);
    sum += rho[0];
  }
  return 0.5 * sum;
}

class RobustSolver::Problem {
 public:
  Problem(const std::vector<GraphEdge>& graph_edges, const std::vector<size_t>& held,
          std::vector<Eigen::Vector3d>* poses)
      : edges(graph_edges), ceres(OwnNothing()) {
    for (Eigen::Vector3d& pose : *poses) ceres.AddParameterBlock(pose.data(), 3);
    for (const size_t i : held) ceres.SetParameterBlockConstant((*poses)[i].data());
    for (const GraphEdge& edge : edges) {
      ceres.AddResidualBlock(edge.factor.get(), edge.may_be_wrong ? &loss : nullptr, (*poses)[edge.from].data(),
                             (*poses)[edge.to].data());
    }
  }

  const std::vector<GraphEdge> edges;  // Keeps the factors alive.
  GemanMcClureLoss loss{1.0};
  ceres::Problem ceres;
};

RobustSolver::RobustSolver(const std::vector<Eigen::Vector3d>& poses, const std::vector<GraphEdge>& edges,
                           const std::vector<size_t>& held)
    : poses_(poses), problem_(std::make_unique<Problem>(edges, held, &poses_)) {}

RobustSolver::~RobustSolver() = default;

void RobustSolver::Solve(double scale, int max_iterations, double tolerance) {
  problem_->loss = GemanMcClureLoss(scale);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = tolerance;
  // Nearly undamped from the start: poses are near their optimum, or no step is any better than the full one.
  options.initial_trust_region_radius = 1e9;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  std::string error;
  CHECK(options.IsValid(&error)) << error;  // Ceres may have been built without SuiteSparse.
  ceres::Solver::Summary summary;
  [[maybe_unused]] const OneOpenMpThread one_thread;
  ceres::Solve(options, &problem_->ceres, &summary);
  LOG_IF(WARNING, !summary.IsSolutionUsable()) << summary.message;
  final_cost_ = summary.IsSolutionUsable() ? summary.final_cost : std::numeric_limits<double>::infinity();
  iterations_ += summary.num_successful_steps + summary.num_unsuccessful_steps;
}

}  // namespace arborslam
