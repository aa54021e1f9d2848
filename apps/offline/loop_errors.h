#ifndef ARBORSLAM_APPS_OFFLINE_LOOP_ERRORS_H_
#define ARBORSLAM_APPS_OFFLINE_LOOP_ERRORS_H_

#include <cstddef>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/loop/loop_closer.h"
#include "backend/posed_scan.h"
#include "core/evaluation/association.h"
#include "core/map/submap.h"

namespace arborslam {

/// How right a run's loops are. Only those count whose keyframe, and one of whose submap's, the reference knows.
struct LoopErrors {
  size_t num_tried = 0;
  size_t num_accepted = 0;
  size_t num_false = 0;          ///< Accepted, though off by more than `kMaxTranslation` or `kMaxRotation`.
  double translation_rms = 0.0;  ///< [m], of those accepted,
  double translation_max = 0.0;  ///< [m], and the greatest.

  /// Less than to the next tree or row, more than a submap bends.
  static constexpr double kMaxTranslation = 0.5;  ///< [m]
  static constexpr double kMaxRotation = 0.15;    ///< [rad]

  /// True ones among those accepted; 1 when none was.
  double Precision() const;
  /// True ones accepted among those tried, all of which were near enough to see the same things; 1 when none was.
  double Recall() const;
};

/// Compares where keyframes were found in submaps with the reference: as seen from that keyframe of the submap which
/// lies nearest to the place. (From the submap's first keyframe, a small error in its heading would count more the
/// farther off the place is.)
/// @param graph as the run was tracked, before loops were closed: its submaps' keyframes lie as their scans lie in the
///              maps in which loops were found.
/// @param pairs with headings; poses of `scans` and their true ones.
LoopErrors EvaluateLoops(const std::vector<LoopCandidate>& loops, const std::vector<Submap>& submaps,
                         const std::vector<PosedScan>& scans, const PoseGraph& graph,
                         const std::vector<PosePair>& pairs);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_LOOP_ERRORS_H_
