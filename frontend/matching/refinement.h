#ifndef ARBORSLAM_FRONTEND_MATCHING_REFINEMENT_H_
#define ARBORSLAM_FRONTEND_MATCHING_REFINEMENT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "frontend/matching/match_target.h"
#include "frontend/matching/modified_hausdorff.h"

namespace arborslam {

struct RefinementOptions {
  int max_iterations = 12;              ///< Gauss-Newton steps.
  double robust_scale = 0.05;           ///< [m], distance at which a point's weight has fallen to a half (Cauchy).
  double min_step = 3e-4;               ///< [m] and [rad / 10], a step shorter than this ends the iteration.
  double min_information_ratio = 0.04;  ///< A direction that is known this much less well than the best is degenerate.
  double lever_arm = 5.0;               ///< [m], makes a turn comparable with a shift: typical distance of a trunk.
  /// [m], by how much points are moved to measure how firmly the map holds them: about a cell, and more than a match
  /// errs by.
  double covariance_step = 0.05;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("max_iterations", max_iterations);
    visit("robust_scale", robust_scale);
    visit("min_step", min_step);
    visit("min_information_ratio", min_information_ratio);
    visit("lever_arm", lever_arm);
    visit("covariance_step", covariance_step);
  }
};

/// A pose refined to a fraction of a cell.
struct RefinementResult {
  SE2 pose;  ///< T_target_base.
  /// (x, y, theta) in the base frame, [m, rad]; 0 in degenerate directions.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  MhdResult mhd;  ///< On the distances to the landmarks' centroids, at `pose`.
  int iterations = 0;
  int num_degenerate = 0;                                      ///< Directions, 0 to 3.
  Eigen::Matrix3d degenerate_basis = Eigen::Matrix3d::Zero();  ///< Its first `num_degenerate` columns: unit directions
                                                               ///< (x, y, theta * lever_arm) in the base frame.
};

/// Minimises the trimmed, robustly weighted squared distances of `points` [m, base frame] to the landmarks nearest
/// them, by Gauss-Newton from `initial`, with the K best points (paper eq. 12) chosen anew in every step.
///
/// Degenerate directions (after Zhang, Kaess and Singh 2016) keep the value they have in `prediction`. The information
/// is that of `MatchInformation`; 0 when `with_information` is false, which saves much of the time.
RefinementResult Refine(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& initial,
                        const SE2& prediction, const MhdOptions& mhd, const RefinementOptions& options,
                        bool with_information = true);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MATCHING_REFINEMENT_H_
