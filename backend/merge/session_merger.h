#ifndef ARBORSLAM_BACKEND_MERGE_SESSION_MERGER_H_
#define ARBORSLAM_BACKEND_MERGE_SESSION_MERGER_H_

#include <cstddef>
#include <vector>

#include "backend/global_solution.h"
#include "backend/merge/place_votes.h"
#include "backend/slam_options.h"
#include "backend/store/session_contents.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

/// How the map of several sessions was made consistent.
struct MergeSolution : GlobalSolution {
  // Of the loops those from one session, as it was given to the merger, to another.
  size_t num_cross_tried = 0;
  size_t num_cross_accepted = 0;
};

/// Makes one map of several sessions whose relative poses are not known. Each is placed in what there is by votes of
/// its keyframes (`VoteOnPlace`), which become loops; at the end all is solved together, as a run's end does it: loops
/// across the sessions, optimisation, refinement. For one thread; the same bits for any number of threads.
class SessionMerger {
 public:
  /// @param options that all sessions were made with.
  /// @param first   `Completed`, and so must be those that follow, all of planar scans or all of sweeps. Its first
  ///                keyframe stays where it is: the map's frame is this session's.
  SessionMerger(const SlamOptions& options, const MergeOptions& merge, int num_threads, SessionContents first);

  /// Places a session in the map so far and adds it. Does nothing when it cannot be placed: the votes tell why.
  PlaceVotes Add(const SessionContents& next);

  /// Solves all together; nothing may be added after it.
  MergeSolution Finish();

  /// All sessions as one: their recordings, scans, keyframes and submaps in the order in which they were added,
  /// numbered throughout; stamps are kept.
  const SessionContents& merged() const { return merged_; }

 private:
  // Counts the loops across sessions.
  void CountCross(MergeSolution* solution) const;

  SlamOptions options_;
  MergeOptions merge_;
  int num_threads_;
  Matcher matcher_;
  SessionContents merged_;
  std::vector<size_t> ends_;  // Of each session the number of keyframes up to its last one.
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_MERGE_SESSION_MERGER_H_
