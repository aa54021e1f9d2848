#ifndef ARBORSLAM_APPS_OFFLINE_SUMMARY_H_
#define ARBORSLAM_APPS_OFFLINE_SUMMARY_H_

#include <optional>
#include <string>
#include <vector>

#include "apps/offline/joint_map.h"
#include "apps/offline/loop_errors.h"
#include "backend/slam.h"
#include "core/evaluation/trajectory_metrics.h"

namespace arborslam {

/// A run's errors against its reference.
struct RunErrors {
  TrajectoryEvaluation trajectory;  ///< The optimised one, SE(2)-aligned.
  TrajectoryEvaluation odometry;    ///< The causal one, likewise.
  size_t unmatched_poses = 0;       ///< Poses without a partner in the reference.
  std::optional<LoopErrors> loops;  ///< None if the reference has no headings.
};

/// What became of the 3D map.
struct CloudRecord {
  size_t num_sweeps = 0;    ///< That it was made of.
  size_t num_points = 0;    ///< 0: there is none.
  double voxel_size = 0.0;  ///< [m]
};

/// All that summary.json tells.
struct RunRecord {
  std::string input;
  int num_threads = 1;
  bool odometry_only = false;
  bool is_interrupted = false;
  std::vector<std::string> notices;  ///< Of the reader.
  std::vector<ScanResult> scans;     ///< In the order of the file.
  FinishResult finish;               ///< Of the recording by itself.
  RunVerdict verdict;                ///< Whether to trust it.
  std::optional<JoinRecord> join;    ///< Of a recording that was to be placed in the map of a session.
  std::optional<CloudRecord> cloud;  ///< None if none was made.
  bool maps_are_whole = true;        ///< False: the second reading was interrupted.
  double maps_ms = 0.0;              ///< [ms], the second reading and the maps made from it.
  size_t num_submaps = 0;
  double wall_seconds = 0.0;
  std::optional<RunErrors> errors;
};

/// summary.json (its keys carry their units): the input, counts, every rejected or skipped scan with its reason, every
/// loop that was tried with its figures, where it was placed in a session's map, times of the stages (median, p95,
/// max), peak memory, and the errors if there was a reference.
std::string SummaryJson(const RunRecord& record);

/// The same in a few lines for people.
std::string SummaryText(const RunRecord& record);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_SUMMARY_H_
