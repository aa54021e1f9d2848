#include "apps/offline/joint_map.h"

#include <utility>

#include "core/stopwatch.h"

namespace arborslam {

JointMap Join(const SlamOptions& options, const MergeOptions& merge, int num_threads, const std::string& path,
              SessionContents map, const SessionContents& recording) {
  JointMap joint;
  joint.record.session = path;
  Stopwatch stopwatch;
  SessionMerger merger(options, merge, num_threads, std::move(map));
  joint.record.votes = merger.Add(recording);
  joint.record.place_ms = stopwatch.Lap();
  if (!joint.record.votes.reason.empty()) return joint;
  joint.record.solution = merger.Finish();
  joint.contents = merger.merged();
  return joint;
}

std::string TextOf(const JoinRecord& record) {
  if (!record.votes.reason.empty()) {
    return "no certain place in the map of " + record.session + " (" + TextOf(record.votes) + ": " +
           record.votes.reason + ")";
  }
  const MergeSolution& solution = record.solution;
  return "lies at " + TextOf(record.votes.T_a_b) + " in the map of " + record.session + " (" + TextOf(record.votes) +
         "); loops across sessions: " + std::to_string(solution.num_cross_accepted) + " accepted of " +
         std::to_string(solution.num_cross_tried) + " tried";
}

}  // namespace arborslam
