#ifndef ARBORSLAM_APPS_OFFLINE_JOINT_MAP_H_
#define ARBORSLAM_APPS_OFFLINE_JOINT_MAP_H_

#include <optional>
#include <string>

#include "backend/merge/place_votes.h"
#include "backend/merge/session_merger.h"
#include "backend/slam_options.h"
#include "backend/store/session_contents.h"

namespace arborslam {

/// How a recording was placed in the map of a session.
struct JoinRecord {
  std::string session;     ///< Path of its file.
  PlaceVotes votes;        ///< Of the recording's keyframes; with a reason when it has no certain place.
  MergeSolution solution;  ///< Of both together; empty when it has no place.
  double place_ms = 0.0;   ///< [ms], finding the place.
};

/// A recording that was mapped by itself, and a session's map that it is to be placed in.
struct JointMap {
  JoinRecord record;
  std::optional<SessionContents> contents;  ///< Both together, this recording last; nothing when it has no place.
};

/// Makes one map of a session's and of a recording's, in the frame of the first, as `SessionMerger` does.
/// @param map       `Completed`; `path` is its file.
/// @param recording finished, made with the same `options`, of the same kind of lidar.
JointMap Join(const SlamOptions& options, const MergeOptions& merge, int num_threads, const std::string& path,
              SessionContents map, const SessionContents& recording);

/// What became of it, in one line.
std::string TextOf(const JoinRecord& record);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_JOINT_MAP_H_
