#ifndef ARBORSLAM_BACKEND_LOOP_LOOP_CLOSER_H_
#define ARBORSLAM_BACKEND_LOOP_LOOP_CLOSER_H_

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "core/map/min_pyramid.h"
#include "core/map/occupancy_grid.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

struct LoopOptions {
  double candidate_radius = 8.0;        ///< [m], a keyframe this near to a submap's path is tried against the submap.
  int keyframe_stride = 12;             ///< Every so many keyframes are tried.
  int max_submaps = 4;                  ///< Of the submaps near to a keyframe, so many of the nearest are tried.
  double search_translation = 1.0;      ///< [m], half width of the search around the graph's estimate at least,
  double search_rotation = 0.1;         ///< [rad], the same in heading;
  double max_search_translation = 4.0;  ///< [m], and at most: in between it is three standard deviations,
  double max_search_rotation = 0.3;     ///< [rad], of the heading likewise.
  double rival_translation = 5.0;  ///< [m], so far around a loop no second pose may fit nearly as well: more than from
                                   ///< tree to tree and from row to row.
  double rival_share = 0.4;  ///< Least share of the scan's points by which such poses are judged: points where the
                             ///< submap's scans have not looked do not count, for there the stand may go on.
  int drift_votes = 5;       ///< Beyond the greatest window, so many scans of one stretch must recognise places
                             ///< that agree on how far the stretch has drifted; 0: windows are all.
  double max_score = 0.08;   ///< [m], a loop's MHD may not exceed this.
  double min_overlap = 0.6;  ///< Share of the scan's points that must meet the submap.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("candidate_radius", candidate_radius);
    visit("keyframe_stride", keyframe_stride);
    visit("max_submaps", max_submaps);
    visit("search_translation", search_translation);
    visit("search_rotation", search_rotation);
    visit("max_search_translation", max_search_translation);
    visit("max_search_rotation", max_search_rotation);
    visit("rival_translation", rival_translation);
    visit("rival_share", rival_share);
    visit("drift_votes", drift_votes);
    visit("max_score", max_score);
    visit("min_overlap", min_overlap);
  }
};

/// Why a loop that was found does not count: `PoseGraph::Optimize` dropped it.
inline constexpr const char* kContradictsOthers = "contradicts the others";

/// One pair that was tried, and what came of it.
struct LoopCandidate {
  KeyframeId keyframe;
  SubmapId submap;
  SE2 prediction;                   ///< T_submap_base by the graph: the middle of the window that was searched,
  double search_translation = 0.0;  ///< [m], half the window's width,
  double search_rotation = 0.0;     ///< [rad], likewise.
  MatchResult match;
  bool accepted = false;
  std::string reason;  ///< Why it was refused; empty when accepted.
};

using LoopPair = std::pair<SubmapId, KeyframeId>;

/// Each pair as it was tried last.
using LoopsByPair = std::map<LoopPair, LoopCandidate>;

/// Finds where keyframes see submaps of another time again (design section 3, step 9):
/// - candidates by position, in a window that follows how well the keyframe's pose is known relative to the submap;
/// - match by branch and bound, checks by score, overlap and uniqueness. Orchards repeat themselves: a loop one tree or
///   one row off fits as well as the true one wherever the stand is regular and no end of it is in sight. So a loop
///   counts only if no pose within `rival_translation` fits nearly as well, however narrow the window was in which it
///   was found: a drift that the graph knows nothing of would otherwise have left the true pose outside of it. And
///   such a pose is judged by what the submap's scans have seen, things and free land, for where a submap ends the
///   stand may go on: in an exact grid nothing is accepted but what sees the grid end;
/// - neither scans nor submaps of stretches in which the run was lost are tried: what few scans there say of an
///   arrangement is a guess;
/// - mutual consistency is left to `PoseGraph::Optimize`, whose graduated non-convexity weighs all loops together along
///   with what the run itself measured; a largest clique of pairwise consistent loops sees only pairs, and would have
///   to guess the drift between them.
class LoopCloser {
 public:
  LoopCloser(const LoopOptions& options, const MatcherOptions& matcher_options, const Matcher& matcher,
             const OccupancyGridOptions& grid);

  /// All candidates of a run, in the order of submaps and keyframes whatever the number of threads.
  /// @param tracked the graph with which the cells of `submaps` were made: their keyframes lie in them as in it.
  /// @param tried those of earlier searches. Such a pair is tried again only if it was not accepted, and the graph has
  ///              changed so much that another place may be found for it.
  std::vector<LoopCandidate> FindAll(const PoseGraph& graph, const PoseGraph& tracked,
                                     const std::vector<Keyframe>& keyframes, const std::vector<Submap>& submaps,
                                     const LoopsByPair& tried, int num_threads) const;

 private:
  // Matches a candidate's scan to its submap in the candidate's window, and judges the match; `seen` tells what of the
  // submap was seen.
  void Judge(const MatchTarget& target, const std::function<MinPyramid*()>& seen,
             const std::vector<Eigen::Vector2f>& points, LoopCandidate* candidate) const;

  LoopOptions options_;
  double max_distance_;
  Matcher matcher_;
  OccupancyGridOptions grid_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_LOOP_CLOSER_H_
