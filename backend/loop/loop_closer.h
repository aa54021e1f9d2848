#ifndef ARBORSLAM_BACKEND_LOOP_LOOP_CLOSER_H_
#define ARBORSLAM_BACKEND_LOOP_LOOP_CLOSER_H_

#include <string>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

struct LoopOptions {
  double candidate_radius = 8.0;    ///< [m], a keyframe this near to a submap's path is tried against the submap.
  int keyframe_stride = 12;         ///< Every so many keyframes are tried.
  double search_translation = 1.0;  ///< [m], half width of the search around the graph's estimate.
  double search_rotation = 0.1;     ///< [rad], the same in heading.
  double max_score = 0.08;          ///< [m], a loop's MHD may not exceed this.
  double min_overlap = 0.6;         ///< Share of the scan's points that must meet the submap.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("candidate_radius", candidate_radius);
    visit("keyframe_stride", keyframe_stride);
    visit("search_translation", search_translation);
    visit("search_rotation", search_rotation);
    visit("max_score", max_score);
    visit("min_overlap", min_overlap);
  }
};

/// One pair that was tried, and what came of it.
struct LoopCandidate {
  KeyframeId keyframe;
  SubmapId submap;
  MatchResult match;
  bool accepted = false;
  std::string reason;  ///< Why it was refused; empty when accepted.
};

/// Finds where keyframes see submaps of another time again: candidates by position, match by branch and bound, checks
/// by score, overlap and uniqueness (design section 3, step 9).
class LoopCloser {
 public:
  LoopCloser(const LoopOptions& options, const MatcherOptions& matcher_options, const Matcher& matcher,
             double cell_size);

  /// All candidates of a run, in the order of submaps and keyframes whatever the number of threads.
  std::vector<LoopCandidate> FindAll(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                     const std::vector<Submap>& submaps, int num_threads) const;

 private:
  LoopOptions options_;
  double max_distance_;
  Matcher matcher_;
  double cell_size_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_LOOP_CLOSER_H_
