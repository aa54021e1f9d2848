#ifndef ARBORSLAM_FRONTEND_MATCHING_MATCH_COVARIANCE_H_
#define ARBORSLAM_FRONTEND_MATCHING_MATCH_COVARIANCE_H_

#include <Eigen/Core>
#include <vector>

#include "core/geometry/se2.h"
#include "frontend/matching/match_target.h"
#include "frontend/matching/modified_hausdorff.h"

namespace arborslam {

/// How the covariance of a match is measured.
struct MatchCovarianceOptions {
  double robust_scale;  ///< [m], the refinement's: where a point's weight has fallen to a half.
  /// [m], by how much points are moved to measure the slope of the force that acts on the pose; doubled up to twice
  /// while it is less than the standard error that follows.
  double step;
};

/// How fast the force on a pose T_target_base rises as the pose moves away from it: the Hessian of what the refinement
/// minimises, (x, y, theta) in the base frame, measured by moving the points by `options.step` to either side and
/// associating anew. Along a direction that the map does not determine it is 0, give or take the noise; the Hessian of
/// Gauss-Newton is not, since it takes each point to be tied to its cell.
Eigen::Matrix3d ForceSlope(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& pose,
                           const MhdOptions& mhd, const MatchCovarianceOptions& options);

/// The information of a pose T_target_base that the refinement has found: (x, y, theta) in the base frame, [m, rad],
/// confined to the image of `free_directions` (orthonormal columns (x, y, theta * lever_arm), base frame; at most
/// three); `lever_arm` in metres. Zero when fewer than four patches of ground take part.
///
/// The covariance is that of an M-estimator, A^-1 B A^-1 (Huber 1967), where
/// - A is the slope of the *whole* estimating function, measured by moving the pose and associating anew: as a pose
///   shifts, points change over from cell to cell, so that a thick map pulls back far less than the fixed pairs of
///   Gauss-Newton would (these claim a tenth of the true error). The function has steps; its slope is therefore
///   measured over more than the standard error (Newey and McFadden 1994, section 7.3). Among leaves, which fill their
///   place at random, a match always finds some pose that seems firm, so A shrinks in the directions in which the slope
///   over twice the step is less than the robust weights make that of a firm hold.
/// - B sums the force by patches of a metre before it is squared, since the points on one trunk or one stretch of
///   hedge err together (Liang and Zeger 1986), with the usual correction for the fitted parameters;
/// - B also holds a range offset that all points share: rays clear the near side of what they meet, so that a map's
///   surfaces lie deeper than a scan's. Its size is estimated from the match; it shifts the pose where the surroundings
///   are lopsided, as beside a hedge.
Eigen::Matrix3d MatchInformation(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& pose,
                                 const MhdOptions& mhd, const MatchCovarianceOptions& options, double lever_arm,
                                 const Eigen::Matrix<double, 3, Eigen::Dynamic>& free_directions);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MATCHING_MATCH_COVARIANCE_H_
