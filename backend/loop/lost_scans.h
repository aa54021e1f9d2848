#ifndef ARBORSLAM_BACKEND_LOOP_LOST_SCANS_H_
#define ARBORSLAM_BACKEND_LOOP_LOST_SCANS_H_

#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"
#include "frontend/tracking/tracker.h"

namespace arborslam {

/// Where tracking was lost and a new map was begun, tracks the scans before it backwards in the new map: scan by scan
/// from the gap (`Constraint::Kind::kGap`) to earlier ones, each searched around the pose of the scan that follows it,
/// as the tracker searches forwards. A scan that is found hangs on the new map from then on, with its match as its only
/// measurement; the gap moves before it.
///
/// Scans that the old map rejected are found until five in a row are not. Scans that the old map holds are taken over
/// as long as they fit the new map clearly better, as those do that were taken elsewhere and matched by chance; all of
/// them if the old map is a start that failed, of at most ten keyframes. A longer one is joined as a whole, by
/// recognised places.
/// @param submaps   finished ones.
/// @param keyframes keyframe i with id i.
/// @return the keyframes that were found, ascending.
std::vector<KeyframeId> RecoverLostScans(const TrackerOptions& options, const Matcher& matcher, double cell_size,
                                         double max_distance, const std::vector<Keyframe>& keyframes,
                                         const std::vector<Submap>& submaps, PoseGraph* graph);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_LOST_SCANS_H_
