#include "backend/factors/relative_pose_factor.h"

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/backend/factors/numeric_jacobian.h"
#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

using Factor = std::unique_ptr<ceres::CostFunction>;

// Information of every rank from 0 to 3.
Eigen::Matrix3d InformationOfRank(int rank, Random* random) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (int i = 0; i < rank; ++i) {
    const Eigen::Vector3d row(3.0 * random->Gaussian(), 3.0 * random->Gaussian(), 20.0 * random->Gaussian());
    information += row * row.transpose();
  }
  return information;
}

// Headings anywhere, or within rounding and a differentiation step of the seam at +-pi.
double HeadingNearSeam(int i, Random* random) {
  const double offsets[] = {0.0, 1e-12, -1e-12, 1e-7, -1e-7, 0.01};
  return i % 3 == 0 ? random->Uniform(-kPi, kPi) : kPi + offsets[i % 6];
}

TEST(RelativePoseFactor, CostsNothingAtTheMeasurement) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const SE2 T_w_a(random.Gaussian(), random.Gaussian(), HeadingNearSeam(i, &random));
    const SE2 T_a_b(random.Gaussian(), random.Gaussian(), HeadingNearSeam(i / 3, &random));
    const Factor factor(CreateRelativePoseFactor(T_a_b, RandomInformation(&random, 0.01, 0.002)));
    EXPECT_LT(ResidualsOf(*factor, {T_w_a.vector(), (T_w_a * T_a_b).vector()}).norm(), 1e-9) << T_w_a << T_a_b;
  }
}

TEST(RelativePoseFactor, CostsTheMahalanobisDistance) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const SE2 T_w_a = RandomPose(&random, 50.0);
    const SE2 T_a_b = RandomPose(&random, 5.0);
    const SE2 error(0.1 * random.Gaussian(), 0.1 * random.Gaussian(), random.Uniform(-3.1, 3.1));
    const Eigen::Matrix3d information = InformationOfRank(i % 4, &random);
    const Factor factor(CreateRelativePoseFactor(T_a_b, information));
    const double expected = error.vector().dot(information * error.vector());
    const double squared = ResidualsOf(*factor, {T_w_a.vector(), (T_w_a * T_a_b * error).vector()}).squaredNorm();
    EXPECT_NEAR(squared, expected, 1e-9 * (1.0 + expected));
  }
}

TEST(RelativePoseFactor, WholeTurnsOfAParameterChangeNothing) {
  Random random(3);
  const SE2 T_a_b = RandomPose(&random, 5.0);
  const Factor factor(CreateRelativePoseFactor(T_a_b, RandomInformation(&random, 0.1, 0.1)));
  const Eigen::Vector3d a = RandomPose(&random, 5.0).vector();
  const Eigen::Vector3d b = RandomPose(&random, 5.0).vector();
  const Eigen::Vector3d turn(0.0, 0.0, 2.0 * kPi);
  EXPECT_TRUE(ResidualsOf(*factor, {a + 2.0 * turn, b - turn}).isApprox(ResidualsOf(*factor, {a, b}), 1e-9));
}

TEST(RelativePoseFactor, JacobiansAreTheDerivatives) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const SE2 T_w_a(random.Gaussian(), random.Gaussian(), HeadingNearSeam(i, &random));
    const SE2 T_a_b(random.Gaussian(), random.Gaussian(), HeadingNearSeam(i / 3, &random));
    const SE2 error(random.Gaussian(), random.Gaussian(), random.Uniform(-3.0, 3.0));
    const Factor factor(CreateRelativePoseFactor(T_a_b, InformationOfRank(i % 4, &random)));
    const std::vector<Eigen::Vector3d> poses{T_w_a.vector(), (T_w_a * T_a_b * error).vector()};
    const Eigen::MatrixXd expected = NumericJacobianOf(*factor, poses);
    EXPECT_LT((JacobianOf(*factor, poses) - expected).cwiseAbs().maxCoeff(), 1e-6 * (1.0 + expected.norm())) << i;
  }
}

TEST(RelativePoseFactor, EitherJacobianMayBeLeftOut) {
  Random random(5);
  const Factor factor(CreateRelativePoseFactor(RandomPose(&random, 5.0), RandomInformation(&random, 0.1, 0.1)));
  const std::vector<Eigen::Vector3d> poses{RandomPose(&random, 5.0).vector(), RandomPose(&random, 5.0).vector()};
  const Eigen::MatrixXd expected = JacobianOf(*factor, poses);
  const double* parameters[] = {poses[0].data(), poses[1].data()};
  for (int wanted = 0; wanted < 2; ++wanted) {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> jacobian;
    double* jacobians[] = {nullptr, nullptr};
    jacobians[wanted] = jacobian.data();
    Eigen::Vector3d residuals;
    ASSERT_TRUE(factor->Evaluate(parameters, residuals.data(), jacobians));
    EXPECT_EQ(jacobian, expected.middleCols<3>(3 * wanted));
  }
}

TEST(SquareRoot, SquaredIsTheInformation) {
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d information = InformationOfRank(i % 4, &random);
    const Eigen::Matrix3d root = SquareRoot(information);
    EXPECT_LT((root.transpose() * root - information).norm(), 1e-12 * (1.0 + information.norm()));
  }
}

TEST(SquareRoot, NegativeEigenvaluesCountAsNothing) {
  const Eigen::Matrix3d root = SquareRoot(Eigen::Vector3d(4.0, -1.0, 9.0).asDiagonal());
  EXPECT_TRUE((root.transpose() * root).isApprox(Eigen::Matrix3d(Eigen::Vector3d(4.0, 0.0, 9.0).asDiagonal())));
}

}  // namespace
}  // namespace arborslam
