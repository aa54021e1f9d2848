#ifndef ARBORSLAM_BACKEND_FACTORS_MARGINAL_PRIOR_FACTOR_H_
#define ARBORSLAM_BACKEND_FACTORS_MARGINAL_PRIOR_FACTOR_H_

#include <Eigen/Core>
#include <vector>

#include "core/geometry/se2.h"

namespace ceres {
class CostFunction;
}

namespace arborslam {

/// What is left of marginalised poses: a dense Gaussian over the poses they were connected to,
///
///   r = offset + jacobian * (x - linearisation_point),
///
/// with angles' differences wrapped. Its Jacobian stays that of the linearisation point.
struct MarginalPrior {
  std::vector<SE2> linearisation_point;  ///< n poses.
  Eigen::MatrixXd jacobian;              ///< r x 3n.
  Eigen::VectorXd offset;                ///< r.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(linearisation_point, jacobian, offset);
  }
};

/// The cost of `prior`, over its n poses as blocks of x, y, theta. The caller owns the result.
ceres::CostFunction* CreateMarginalPriorFactor(const MarginalPrior& prior);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_FACTORS_MARGINAL_PRIOR_FACTOR_H_
