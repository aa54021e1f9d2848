#include "backend/factors/marginal_prior_factor.h"

#include <ceres/cost_function.h>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

class MarginalPriorFactor : public ceres::CostFunction {
 public:
  explicit MarginalPriorFactor(const MarginalPrior& prior) : prior_(prior) {
    set_num_residuals(static_cast<int>(prior.offset.size()));
    mutable_parameter_block_sizes()->assign(prior.linearisation_point.size(), 3);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto num_poses = static_cast<Eigen::Index>(prior_.linearisation_point.size());
    Eigen::VectorXd difference(3 * num_poses);
    for (Eigen::Index i = 0; i < num_poses; ++i) {
      const Eigen::Map<const Eigen::Vector3d> pose(parameters[i]);
      difference.segment<3>(3 * i) = pose - prior_.linearisation_point[static_cast<size_t>(i)].vector();
      difference(3 * i + 2) = NormalizeAngle(difference(3 * i + 2));
    }
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = prior_.offset + prior_.jacobian * difference;
    if (jacobians == nullptr) return true;
    for (Eigen::Index i = 0; i < num_poses; ++i) {
      if (jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(jacobians[i], num_residuals(), 3) =
          prior_.jacobian.middleCols<3>(3 * i);
    }
    return true;
  }

 private:
  const MarginalPrior prior_;
};

}  // namespace

ceres::CostFunction* CreateMarginalPriorFactor(const MarginalPrior& prior) { return new MarginalPriorFactor(prior); }

}  // namespace arborslam
