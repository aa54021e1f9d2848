#ifndef ARBORSLAM_BACKEND_LOOP_DRIFTED_LOOPS_H_
#define ARBORSLAM_BACKEND_LOOP_DRIFTED_LOOPS_H_

#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/loop/loop_closer.h"
#include "backend/loop/place_recognizer.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

/// Finds where keyframes see submaps again from which they may have drifted farther than any window of `LoopCloser`
/// reaches:
/// - keyframes about every metre are asked where they were taken (`PlaceRecognizer`), among the submaps relative to
///   which the graph knows their pose so little, near which they may be, and with whose piece of the path no loop joins
///   theirs. Where poses are known well, nothing is asked;
/// - an answer may not differ from the graph's heading by more than its covariance can explain;
/// - it counts only with `LoopOptions::drift_votes` answers of the same stretch of path that agree on how far the
///   stretch has drifted, and few that contradict: single answers are wrong now and then.
class DriftedLoopFinder {
 public:
  /// @param cell_size [m] of the grids that submaps come from.
  DriftedLoopFinder(const LoopOptions& options, const PlaceOptions& place, const MatcherOptions& matcher_options,
                    const Matcher& matcher, double cell_size);

  /// All answers in the order of the keyframes, whatever the number of threads; accepted are those that count.
  std::vector<LoopCandidate> FindAll(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                     const std::vector<Submap>& submaps, int num_threads) const;

 private:
  LoopOptions options_;
  PlaceOptions place_options_;
  MatcherOptions matcher_options_;
  Matcher matcher_;
  double cell_size_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_DRIFTED_LOOPS_H_
