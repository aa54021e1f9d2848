#ifndef ARBORSLAM_BACKEND_SCAN_RESULT_H_
#define ARBORSLAM_BACKEND_SCAN_RESULT_H_

#include <string>

#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

/// What became of a scan.
enum class ScanStatus {
  kMatched,    ///< Its pose was measured.
  kPredicted,  ///< Rejected: its pose is the motion model's, as the window sees it.
  kSkipped,    ///< It has no pose.
};

/// One scan's result, as known when it came.
struct ScanResult {
  double stamp = 0.0;  ///< [s], the middle of the sweep as it was taken to be then.
  ScanStatus status = ScanStatus::kSkipped;
  std::string reason;          ///< Why the scan was not matched; empty if it was.
  SE2 T_odom_base;             ///< The window's estimate; meaningless when skipped.
  Tilt3 tilt;                  ///< Of the lidar over T_odom_base; all 0 for planar scans.
  bool has_ground = true;      ///< False: a sweep in which no ground was found; its tilt is that of the one before.
  int num_moving = 0;          ///< Planar points left out since they move.
  MatchResult match;           ///< To the older active submap.
  bool is_keyframe = false;    ///< Kept as a variable of the estimation.
  bool is_inserted = false;    ///< Clean enough to become part of the maps.
  bool searched_wide = false;  ///< The search around the prediction found nothing good.
  // [ms]
  double project_ms = 0.0;  ///< Reduction to planar points: for a sweep deskewing, ground, projection, moving things.
  double match_ms = 0.0;    ///< Prediction, search, refinement, distance fields.
  double window_ms = 0.0;   ///< Smoothing and marginalisation.
  double insert_ms = 0.0;   ///< Maps.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(stamp, status, reason, T_odom_base, tilt, has_ground, num_moving, match, is_keyframe, is_inserted,
          searched_wide, project_ms, match_ms, window_ms, insert_ms);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_SCAN_RESULT_H_
