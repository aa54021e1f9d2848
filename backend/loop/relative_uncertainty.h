#ifndef ARBORSLAM_BACKEND_LOOP_RELATIVE_UNCERTAINTY_H_
#define ARBORSLAM_BACKEND_LOOP_RELATIVE_UNCERTAINTY_H_

#include <Eigen/Core>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "core/map/ids.h"

namespace arborslam {

/// How well the poses of keyframes are known relative to a submap, cheaply: the covariance along the best chain of
/// submaps that share keyframes, one measurement per step. What other chains and measurements add is left out, and what
/// neighbouring scans err together is not averaged away, so that this is rather too large than too small.
class RelativeUncertainty {
 public:
  explicit RelativeUncertainty(const PoseGraph& graph);

  /// What a submap knows of the others.
  class View {
   public:
    /// Covariance of the keyframe's pose relative to the submap: (x, y, theta) [m, rad] about the keyframe, along the
    /// axes of the map. Nothing when no chain leads there.
    std::optional<Eigen::Matrix3d> Of(KeyframeId keyframe) const;

   private:
    friend class RelativeUncertainty;
    View(const RelativeUncertainty& parent, std::map<int, Eigen::Matrix3d> covariances)
        : parent_(parent), covariances_(std::move(covariances)) {}

    const RelativeUncertainty& parent_;
    std::map<int, Eigen::Matrix3d> covariances_;  // By submap, about its origin.
  };

  /// The view must not outlive this object.
  View From(SubmapId submap) const;

 private:
  // A keyframe as a submap sees it.
  struct Sighting {
    int submap;
    Eigen::Matrix3d covariance;  // Along the axes of the map, about the keyframe.
  };
  // The best keyframe through which one submap knows another.
  struct Link {
    int keyframe;
    Eigen::Matrix3d to_keyframe;
    Eigen::Matrix3d from_keyframe;
  };

  const PoseGraph& graph_;
  std::map<int, std::vector<Sighting>> sightings_;  // By keyframe.
  std::map<int, std::map<int, Link>> links_;        // By submap and submap.
};

/// Half widths of the window in which a pose of some covariance is looked for: three standard deviations.
struct SearchedWindow {
  double translation = 0.0;  ///< [m]
  double rotation = 0.0;     ///< [rad]
};

/// @param covariance of (x, y, theta) [m, rad].
SearchedWindow WindowOf(const Eigen::Matrix3d& covariance);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_RELATIVE_UNCERTAINTY_H_
