#include "backend/graph/robust_solver.h"

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include "backend/factors/relative_pose_factor.h"

namespace arborslam {
namespace {

GraphEdge EdgeAlongX(size_t from, size_t to, double x, bool may_be_wrong) {
  return {from, to,
          std::shared_ptr<ceres::CostFunction>(CreateRelativePoseFactor(SE2(x, 0.0, 0.0), Eigen::Matrix3d::Identity())),
          may_be_wrong};
}

TEST(RobustSolver, ErrorsAndCostsAreInStandardDeviations) {
  const std::vector<GraphEdge> edges{EdgeAlongX(0, 1, 1.0, false), EdgeAlongX(0, 1, 4.0, true)};
  const std::vector<Eigen::Vector3d> poses{Eigen::Vector3d::Zero(), Eigen::Vector3d(1.0, 4.0, 0.0)};
  EXPECT_DOUBLE_EQ(ErrorOf(edges[0], poses), 4.0);
  EXPECT_DOUBLE_EQ(ErrorOf(edges[1], poses), 5.0);
  EXPECT_DOUBLE_EQ(CostOf(edges, poses, 5.0), 0.5 * (16.0 + 12.5));
}

TEST(RobustSolver, FindsTheMinimumOfTheRobustCost) {
  // x is measured to be 0 for certain and d perhaps: the minimum of x^2 + s^2 (x - d)^2 / (s^2 + (x - d)^2), by
  // exhaustion; from where the least squares solution is, so that a great scale goes half way and a small one to 0.
  const double d = 6.0;
  for (const double scale : {1.0, 3.0, 5.0, 1000.0}) {
    const auto cost = [&](double x) {
      return 0.5 * (x * x + scale * scale * (x - d) * (x - d) / (scale * scale + (x - d) * (x - d)));
    };
    double best = 0.0;
    for (double x = 0.0; x <= d / 2.0; x += 1e-4) best = cost(x) < cost(best) ? x : best;
    const std::vector<GraphEdge> edges{EdgeAlongX(0, 1, 0.0, false), EdgeAlongX(0, 1, d, true)};
    RobustSolver solver(std::vector<Eigen::Vector3d>(2, Eigen::Vector3d::Zero()), edges);
    solver.Solve(scale, 100, 1e-12);
    EXPECT_NEAR(solver.poses()[1].x(), best, 1e-3) << scale;
    EXPECT_NEAR(solver.final_cost(), cost(best), 1e-6) << scale;
    EXPECT_NEAR(CostOf(edges, solver.poses(), scale), solver.final_cost(), 1e-9) << scale;
  }
}

TEST(RobustSolver, HoldsTheFirstPoseAndWhatNothingIsKnownOf) {
  const Eigen::Vector3d first(1.0, 2.0, 0.5);
  const Eigen::Vector3d alone(7.0, 8.0, 9.0);
  const std::vector<Eigen::Vector3d> poses{first, Eigen::Vector3d(0.0, 0.0, 0.0), alone};
  RobustSolver solver(poses, {EdgeAlongX(1, 0, -2.0, false)});
  solver.Solve(1.0, 50, 1e-12);
  EXPECT_EQ(solver.poses()[0], first);
  EXPECT_EQ(solver.poses()[2], alone);
  EXPECT_NEAR(solver.final_cost(), 0.0, 1e-9);
  EXPECT_GT(solver.iterations(), 0);
}

}  // namespace
}  // namespace arborslam
