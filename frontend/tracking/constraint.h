#ifndef ARBORSLAM_FRONTEND_TRACKING_CONSTRAINT_H_
#define ARBORSLAM_FRONTEND_TRACKING_CONSTRAINT_H_

#include <Eigen/Core>

#include "core/geometry/se2.h"
#include "core/map/ids.h"

namespace arborslam {

/// A measured relative pose between two variables.
struct Constraint {
  enum class Kind {
    kSubmap,  ///< A scan matched to a submap that was active when it came.
    kMotion,  ///< The motion model between successive keyframes.
    kLoop,    ///< A scan matched to a submap from another time; may be wrong.
    kGap,     ///< Nothing was measured between two successive keyframes: tracking was lost. Hardly any information.
  };
  NodeId from;
  NodeId to;
  SE2 T_from_to;
  Eigen::Matrix3d information;  ///< (x, y, theta) in the frame of `to`, [m, rad]; may be singular.
  Kind kind = Kind::kSubmap;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(from, to, T_from_to, information, kind);
  }
};

/// True for a constraint that a scan's match to a submap measured, or that anchors a submap at its first keyframe.
inline bool IsMatch(const Constraint& constraint) {
  return constraint.kind == Constraint::Kind::kSubmap || constraint.kind == Constraint::Kind::kLoop;
}

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_CONSTRAINT_H_
