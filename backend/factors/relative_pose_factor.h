#ifndef ARBORSLAM_BACKEND_FACTORS_RELATIVE_POSE_FACTOR_H_
#define ARBORSLAM_BACKEND_FACTORS_RELATIVE_POSE_FACTOR_H_

#include <Eigen/Core>

#include "core/geometry/se2.h"

namespace ceres {
class CostFunction;
}

namespace arborslam {

/// The cost of two poses T_w_a and T_w_b (each a block of x, y, theta [m, m, rad]) given a measurement of T_a_b:
///
///   r = S * vec(T_a_b_measured^-1 * T_w_a^-1 * T_w_b),  S^T S = information,
///
/// vec = (x, y, theta), theta wrapped. Three residuals, analytic Jacobians. `information` (in the frame of b) may be
/// singular: its null directions cost nothing. The caller owns the result (a ceres::Problem takes it).
ceres::CostFunction* CreateRelativePoseFactor(const SE2& T_a_b, const Eigen::Matrix3d& information);

/// A square root S of a positive semi-definite matrix: S^T S = information. Negative eigenvalues count as 0.
Eigen::Matrix3d SquareRoot(const Eigen::Matrix3d& information);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_FACTORS_RELATIVE_POSE_FACTOR_H_
