#ifndef ARBORSLAM_BACKEND_RUN_VERDICT_H_
#define ARBORSLAM_BACKEND_RUN_VERDICT_H_

#include <cstddef>
#include <string>
#include <vector>

namespace arborslam {

/// Where the final pose of a scan comes from.
enum class PoseSource {
  kMeasured,      ///< The scan was matched to a map, or began one.
  kInterpolated,  ///< From the measured scans before and after it, by time.
  kUnknown,       ///< Neither is there, or not in one part of the map: the pose is a guess.
};

/// Scans in a row that belong to one map; tracking was lost between segments.
struct MapSegment {
  size_t first_scan = 0;  ///< Index into `Slam::scans`,
  size_t last_scan = 0;   ///< of its first and last measured scan.
  bool is_joined = true;  ///< It is in the frame of the main part, that with the most keyframes.
};

/// Whether the result of a run should be trusted.
enum class RunState {
  kOk,
  kDegraded,  ///< Usable, but for the parts that the reasons name.
  kLost,      ///< Most of the run has no measured pose.
};

/// "ok", "degraded", "lost".
const char* ToString(RunState state);

struct RunVerdict {
  RunState state = RunState::kOk;
  std::vector<std::string> reasons;  ///< For people, with the scans they are about, counted from 1; empty if ok.
};

/// "ok", or "degraded: " and the reasons, in one line.
std::string TextOf(const RunVerdict& verdict);

/// Judges a run by how its scans got their poses:
///   lost      less than half of the scans were measured in the main part of the map;
///   degraded  tracking was lost and a new map begun, joined again or not; or scans lack a measured pose: more than two
///             and 2 % of them, or ten in a row.
/// @param sources  of all scans that have a pose, in their order.
/// @param segments of the same scans.
/// @param index_of the place in the recording of each of these scans, from 0 on.
RunVerdict JudgeRun(const std::vector<PoseSource>& sources, const std::vector<MapSegment>& segments,
                    const std::vector<size_t>& index_of);

/// True for each scan that has a pose in the frame of the main part: measured there, or interpolated.
std::vector<bool> PlacedScans(const std::vector<PoseSource>& sources, const std::vector<MapSegment>& segments);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_RUN_VERDICT_H_
