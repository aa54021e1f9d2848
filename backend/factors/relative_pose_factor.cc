#include "backend/factors/relative_pose_factor.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

class RelativePoseFactor : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  RelativePoseFactor(const SE2& T_a_b, const Eigen::Matrix3d& square_root) : T_a_b_(T_a_b), square_root_(square_root) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> a(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> b(parameters[1]);
    const double c = std::cos(a(2) + T_a_b_.theta());
    const double s = std::sin(a(2) + T_a_b_.theta());
    // Rotates from the world to the frame that b should have.
    const Eigen::Matrix2d rotation = (Eigen::Matrix2d() << c, s, -s, c).finished();
    const Eigen::Vector2d difference = rotation * (b.head<2>() - a.head<2>());
    const Eigen::Vector2d measured = T_a_b_.rotation().transpose() * T_a_b_.translation();

    Eigen::Vector3d error;
    error.head<2>() = difference - measured;
    error(2) = AngleDifference(b(2), a(2) + T_a_b_.theta());
    Eigen::Map<Eigen::Vector3d>(residuals).noalias() = square_root_ * error;

    if (jacobians == nullptr) return true;
    using Jacobian = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    if (jacobians[0] != nullptr) {
      Eigen::Matrix3d jacobian = -Eigen::Matrix3d::Identity();
      jacobian.topLeftCorner<2, 2>() = -rotation;
      jacobian.topRightCorner<2, 1>() = Eigen::Vector2d(difference.y(), -difference.x());
      Eigen::Map<Jacobian>(jacobians[0]).noalias() = square_root_ * jacobian;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
      jacobian.topLeftCorner<2, 2>() = rotation;
      Eigen::Map<Jacobian>(jacobians[1]).noalias() = square_root_ * jacobian;
    }
    return true;
  }

 private:
  const SE2 T_a_b_;
  const Eigen::Matrix3d square_root_;
};

}  // namespace

ceres::CostFunction* CreateRelativePoseFactor(const SE2& T_a_b, const Eigen::Matrix3d& information) {
  return new RelativePoseFactor(T_a_b, SquareRoot(information));
}

Eigen::Matrix3d SquareRoot(const Eigen::Matrix3d& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace arborslam
