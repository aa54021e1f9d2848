#ifndef ARBORSLAM_FRONTEND_MATCHING_BRANCH_AND_BOUND_H_
#define ARBORSLAM_FRONTEND_MATCHING_BRANCH_AND_BOUND_H_

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/min_pyramid.h"
#include "frontend/matching/match_target.h"
#include "frontend/matching/modified_hausdorff.h"

namespace arborslam {

/// What it costs to leave the centre of a search, added to the MHD: where a spoilt scan fits several poses about
/// equally well, the one nearest the prediction is to win.
struct SearchPenalty {
  double per_metre = 0.0;   ///< [m of MHD per m]
  double per_radian = 0.0;  ///< [m of MHD per rad]
};

/// A box of poses around a centre, and the grid of poses in it that is searched: whole cells of the target's field in x
/// and y, `rotation_step` in theta.
struct SearchWindow {
  double translation = 0.5;     ///< [m], half the edge of the box in x and in y.
  double rotation = 0.2;        ///< [rad], half the range of theta.
  double rotation_step = 0.01;  ///< [rad]
  SearchPenalty penalty = SearchPenalty();
};

/// The penalty of `pose` for a search around `center` [m].
double PenaltyOf(const SE2& pose, const SE2& center, const SearchPenalty& penalty);

/// A part of a window that is left out: poses that are near `pose` in position and in heading.
struct Exclusion {
  SE2 pose;
  double translation;        ///< [m]
  double rotation;           ///< [rad]
  bool any_will_do = false;  ///< The search ends with the first pose that costs less than it may, instead of the best.
};

/// Judges poses by what the map has seen: a point that lies where nobody has looked speaks neither for nor against a
/// pose. The K of the MHD is that of the points that are near to the map or lie where it is known to be free.
struct SeenOnly {
  MinPyramid* pyramid;  ///< Of the target and of what is free; levels are added as needed.
  double min_share;     ///< So large a share of all points counts, even if fewer are seen; above `alpha_min` as that.
  int max_near = std::numeric_limits<int>::max();  ///< Where all K points are near to the map, K is no greater.
  /// [m], the mean distance of the points of `min_share`, those that fit best, must be less.
  double max_core_cost = std::numeric_limits<double>::infinity();
};

/// The best pose of a window.
struct SearchResult {
  SE2 pose;                ///< T_target_base.
  double cost = 0.0;       ///< [m], its MHD on quantised cell distances (at most one step too low) and the penalty.
  double core_cost = 0.0;  ///< [m], mean distance of the least K of points, those that fit best.
  int num_used = 0;        ///< Points that the MHD is the mean of, K.
  int64_t num_scored = 0;  ///< Nodes and leaves that were scored.
};

/// The pose on the window's grid around `center` (T_target_base) whose MHD of `points` [m, base frame] to `target`,
/// with the window's penalty, is least: by branch and bound (Olson 2015; Hess et al. 2016) with an exact bound. A
/// point's least distance over a node's box bounds its distance in every leaf from below, and the mean of the K
/// smallest of smaller numbers, for the smallest K, is smaller; so is the penalty of the box's nearest pose. Of equally
/// good poses one is returned, always the same. With `seen_only` a node's K is bounded by the points whose window was
/// seen wholly. Nothing is returned when no pose costs less than `max_cost` [m], or
/// when points or target are empty.
std::optional<SearchResult> BranchAndBound(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                                           const SE2& center, const SearchWindow& window, const MhdOptions& mhd,
                                           double max_cost, const std::optional<Exclusion>& exclusion = std::nullopt,
                                           const std::optional<SeenOnly>& seen_only = std::nullopt);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MATCHING_BRANCH_AND_BOUND_H_
