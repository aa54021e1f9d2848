#ifndef ARBORSLAM_TESTS_BACKEND_FACTORS_NUMERIC_JACOBIAN_H_
#define ARBORSLAM_TESTS_BACKEND_FACTORS_NUMERIC_JACOBIAN_H_

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// The residuals of `factor` at `poses` (x, y, theta each).
inline Eigen::VectorXd ResidualsOf(const ceres::CostFunction& factor, const std::vector<Eigen::Vector3d>& poses) {
  std::vector<const double*> parameters;
  for (const Eigen::Vector3d& pose : poses) parameters.push_back(pose.data());
  Eigen::VectorXd residuals(factor.num_residuals());
  EXPECT_TRUE(factor.Evaluate(parameters.data(), residuals.data(), nullptr));
  return residuals;
}

/// The Jacobian (residuals x 3n) that `factor` gives.
inline Eigen::MatrixXd JacobianOf(const ceres::CostFunction& factor, const std::vector<Eigen::Vector3d>& poses) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  std::vector<const double*> parameters;
  std::vector<RowMajor> blocks(poses.size(), RowMajor(factor.num_residuals(), 3));
  std::vector<double*> block_data;
  for (size_t i = 0; i < poses.size(); ++i) {
    parameters.push_back(poses[i].data());
    block_data.push_back(blocks[i].data());
  }
  Eigen::VectorXd residuals(factor.num_residuals());
  EXPECT_TRUE(factor.Evaluate(parameters.data(), residuals.data(), block_data.data()));
  Eigen::MatrixXd jacobian(factor.num_residuals(), 3 * static_cast<Eigen::Index>(poses.size()));
  for (size_t i = 0; i < poses.size(); ++i) jacobian.middleCols<3>(3 * static_cast<Eigen::Index>(i)) = blocks[i];
  return jacobian;
}

/// The same by central differences.
inline Eigen::MatrixXd NumericJacobianOf(const ceres::CostFunction& factor, const std::vector<Eigen::Vector3d>& poses) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd jacobian(factor.num_residuals(), 3 * static_cast<Eigen::Index>(poses.size()));
  for (Eigen::Index column = 0; column < jacobian.cols(); ++column) {
    std::vector<Eigen::Vector3d> above = poses;
    std::vector<Eigen::Vector3d> below = poses;
    above[static_cast<size_t>(column / 3)](column % 3) += kStep;
    below[static_cast<size_t>(column / 3)](column % 3) -= kStep;
    jacobian.col(column) = (ResidualsOf(factor, above) - ResidualsOf(factor, below)) / (2.0 * kStep);
  }
  return jacobian;
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BACKEND_FACTORS_NUMERIC_JACOBIAN_H_
