#ifndef ARBORSLAM_BACKEND_GRAPH_OVERLAP_DISCOUNT_H_
#define ARBORSLAM_BACKEND_GRAPH_OVERLAP_DISCOUNT_H_

#include "backend/graph/pose_graph.h"

namespace arborslam {

/// [m] of path within which scans err alike when they are matched to maps: they see the same leaves from the same side,
/// and the map's error there is one and the same. Found on simulated orchards, from how much the errors of whole runs
/// exceed what independent scans would leave.
constexpr double kErrorCorrelationLength = 2.0;

/// A copy of `graph` whose information is what is left of it when errors are shared, for covariances that can be
/// believed (`MarginalCovariances`); its optimum is not used. Matches of one keyframe count as one together, for all
/// its maps are made of the same scans, and so do keyframes within `correlation_length` [m] of path: each match counts
/// 1 / (matches of its keyframe * keyframes in that length). Motion is left as it is.
PoseGraph DiscountOverlap(const PoseGraph& graph, double correlation_length = kErrorCorrelationLength);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_GRAPH_OVERLAP_DISCOUNT_H_
