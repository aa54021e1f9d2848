#include "backend/factors/marginal_prior_factor.h"

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/backend/factors/numeric_jacobian.h"
#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

MarginalPrior RandomPrior(int num_poses, int num_residuals, Random* random) {
  MarginalPrior prior;
  for (int i = 0; i < num_poses; ++i) prior.linearisation_point.push_back(RandomPose(random, 20.0));
  prior.jacobian = Eigen::MatrixXd::NullaryExpr(num_residuals, 3 * num_poses, [&] { return random->Gaussian(); });
  prior.offset = Eigen::VectorXd::NullaryExpr(num_residuals, [&] { return random->Gaussian(); });
  return prior;
}

std::vector<Eigen::Vector3d> VectorsOf(const std::vector<SE2>& poses) {
  std::vector<Eigen::Vector3d> vectors;
  for (const SE2& pose : poses) vectors.push_back(pose.vector());
  return vectors;
}

TEST(MarginalPriorFactor, IsTheOffsetAtTheLinearisationPoint) {
  Random random(1);
  const MarginalPrior prior = RandomPrior(3, 5, &random);
  const std::unique_ptr<ceres::CostFunction> factor(CreateMarginalPriorFactor(prior));
  EXPECT_EQ(ResidualsOf(*factor, VectorsOf(prior.linearisation_point)), prior.offset);
}

TEST(MarginalPriorFactor, IsLinearInThePosesAndItsJacobianIsTheDerivative) {
  Random random(2);
  for (int i = 0; i < 60; ++i) {
    const int num_poses = 1 + i % 4;
    const MarginalPrior prior = RandomPrior(num_poses, 1 + i % (3 * num_poses), &random);
    const std::unique_ptr<ceres::CostFunction> factor(CreateMarginalPriorFactor(prior));
    std::vector<Eigen::Vector3d> poses = VectorsOf(prior.linearisation_point);
    Eigen::VectorXd difference(3 * num_poses);
    for (int k = 0; k < num_poses; ++k) {
      difference.segment<3>(3 * k) << random.Gaussian(), random.Gaussian(), random.Uniform(-3.0, 3.0);
      poses[static_cast<size_t>(k)] += difference.segment<3>(3 * k);
    }
    EXPECT_LT((ResidualsOf(*factor, poses) - prior.offset - prior.jacobian * difference).norm(), 1e-9);
    EXPECT_EQ(JacobianOf(*factor, poses), prior.jacobian);
    EXPECT_LT((NumericJacobianOf(*factor, poses) - prior.jacobian).norm(), 1e-6);
  }
}

TEST(MarginalPriorFactor, HeadingsDifferTheShortWayRound) {
  const MarginalPrior prior{{SE2(0.0, 0.0, kPi - 0.01)}, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  const std::unique_ptr<ceres::CostFunction> factor(CreateMarginalPriorFactor(prior));
  EXPECT_NEAR(ResidualsOf(*factor, {{0.0, 0.0, -kPi + 0.02}})(2), 0.03, 1e-12);
  EXPECT_NEAR(ResidualsOf(*factor, {{0.0, 0.0, 5.0 * kPi}})(2), 0.01, 1e-12);
}

}  // namespace
}  // namespace arborslam
