#ifndef ARBORSLAM_FRONTEND_MATCHING_MATCHER_H_
#define ARBORSLAM_FRONTEND_MATCHING_MATCHER_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "frontend/matching/branch_and_bound.h"
#include "frontend/matching/match_target.h"
#include "frontend/matching/modified_hausdorff.h"
#include "frontend/matching/refinement.h"

namespace arborslam {

struct MatcherOptions {
  double max_distance = 0.2;  ///< [m], D_max: points farther from the map than this are outliers (paper: 2-4 cells).
  int max_search_points =
      100;                  ///< The search uses about this many of a scan's points, twice as many to judge uniqueness.
  double max_score = 0.15;  ///< [m], a match whose MHD is above this is poor.
  int min_points = 30;      ///< A scan with fewer points is not matched.
  double max_second_ratio = 0.7;  ///< A match is ambiguous when score / second mode's score exceeds this.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("max_distance", max_distance);
    visit("max_search_points", max_search_points);
    visit("max_score", max_score);
    visit("min_points", min_points);
    visit("max_second_ratio", max_second_ratio);
  }
};

/// What a match is worth.
enum class MatchVerdict {
  kAccepted,
  kTooFewPoints,  ///< The scan or the map has next to nothing to match.
  kPoor,          ///< Score above the gate: spoilt scan, or the place was not found.
  kAmbiguous,     ///< Another pose, well apart, is nearly as good.
  kDegenerate,    ///< Good, but the pose is unknown along at least one direction, where it is the prediction's.
};

/// "accepted", "too few points", ...
const char* ToString(MatchVerdict verdict);

/// True for the verdicts whose pose and information may be used.
inline bool IsUsable(MatchVerdict verdict) {
  return verdict == MatchVerdict::kAccepted || verdict == MatchVerdict::kDegenerate;
}

struct MatchResult {
  MatchVerdict verdict = MatchVerdict::kTooFewPoints;
  SE2 pose;  ///< T_target_base; the prediction when nothing was found.
  /// (x, y, theta) in the base frame, [m, rad]; 0 in degenerate directions.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double score = 0.0;         ///< [m], MHD to the landmarks' centroids.
  double cost = 0.0;          ///< [m], score and the search's penalty for leaving the prediction.
  double inlier_ratio = 0.0;  ///< Share of the points nearer to the map than D_max.
  double second_score = 0.0;  ///< [m], of a pose well apart that fits nearly as well; 0: none is known.
  int num_points = 0;
  int num_degenerate = 0;  ///< Directions that the map does not determine.
  int64_t num_scored = 0;  ///< Poses and boxes of poses that the search scored.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(verdict, pose, information, score, cost, inlier_ratio, second_score, num_points, num_degenerate, num_scored);
  }
};

/// Why a match does not count: its verdict unless it is usable, "score" if that exceeds `max_score` [m], "overlap" if
/// less than `min_overlap` of the points meet the map; empty if it counts.
std::string RefusalReason(const MatchResult& match, double max_score, double min_overlap);

/// Scan to map by exhaustive-equivalent search and continuous refinement (design section 3, step 6).
class Matcher {
 public:
  Matcher(const MatcherOptions& options, const MhdOptions& mhd, const RefinementOptions& refinement);

  /// Searches `window` around `prediction` (T_target_base), then refines.
  /// @param with_information false: the match's information is 0, which saves time when its pose is not the last word.
  MatchResult Match(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& prediction,
                    const SearchWindow& window, bool with_information = true) const;

  /// The same for a search that is only of use if it finds something that costs less than `max_cost` [m]; `kPoor`, with
  /// a score of D_max, when it does not.
  MatchResult MatchBetter(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& prediction,
                          const SearchWindow& window, double max_cost, bool with_information = true) const;

  /// Searches `window` around `match->pose`, without the neighbourhood of that, for a pose that fits nearly as well. If
  /// there is one, the match becomes ambiguous and its second score is that pose's cost [m]. The window may be wider
  /// than the one that the match was found in: a tree or a row farther on things may look the same.
  /// @param seen_only where a map ends things may go on: what it has not seen then does not speak against a rival. Nor
  ///                  does a difference that is no greater than means over as many points scatter.
  void CheckUniqueness(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                       const SearchWindow& window, MatchResult* match,
                       const std::optional<SeenOnly>& seen_only = std::nullopt) const;

  /// Refines from `initial` without a search.
  MatchResult MatchNear(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                        const SE2& initial) const;

 private:
  MatchResult RefineAndJudge(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& initial,
                             const SE2& prediction, bool with_information) const;

  MatcherOptions options_;
  MhdOptions mhd_;
  RefinementOptions refinement_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MATCHING_MATCHER_H_
