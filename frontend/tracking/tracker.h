#ifndef ARBORSLAM_FRONTEND_TRACKING_TRACKER_H_
#define ARBORSLAM_FRONTEND_TRACKING_TRACKER_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/map/ids.h"
#include "core/map/occupancy_grid.h"
#include "core/map/submap.h"
#include "core/sensor/planar_scan.h"
#include "core/sensor/stamped_pose.h"
#include "frontend/matching/matcher.h"
#include "frontend/tracking/constraint.h"

namespace arborslam {

struct TrackerOptions {
  double near_translation = 0.5;  ///< [m], half width of the first search around the prediction (paper: within 0.5 m).
  double near_rotation = 0.2;     ///< [rad], the same in heading (paper: within 0.2 rad).
  double wide_translation = 1.5;  ///< [m], of the second search, made when the first finds nothing good.
  double wide_rotation = 3.1415926535897931;  ///< [rad]
  double near_rotation_step = 0.01;           ///< [rad], by which the first search turns the scan,
  double wide_rotation_step = 0.02;           ///< [rad], and the second one.
  double translation_penalty = 0.06;          ///< [m of MHD per m] that a pose lies from the prediction.
  double rotation_penalty = 0.01;             ///< [m of MHD per rad] that a pose is turned from the prediction.
  double wide_score = 0.10;        ///< [m], the second search is made when the first one's MHD is above this.
  double max_insert_score = 0.10;  ///< [m], a scan whose MHD is above this is spoilt: used, but not put into the maps.
  double submap_length = 60.0;     ///< [m] of path in a submap; a new one is begun every half of this.
  double rebuild_distance = 1.0;   ///< [m] of path in a submap before its distance field is built anew,
  double rebuild_turn = 1.0;       ///< [rad], or of turning.
  double min_occupancy = 0.55;     ///< A cell is matched to when its probability of being occupied reaches this.
  double keyframe_translation = 0.1;  ///< [m], a scan becomes a keyframe when the robot has moved this far,
  double keyframe_rotation = 0.05;    ///< [rad], or turned this far,
  double keyframe_interval = 10.0;    ///< [s], or this long has passed.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("near_translation", near_translation);
    visit("near_rotation", near_rotation);
    visit("wide_translation", wide_translation);
    visit("wide_rotation", wide_rotation);
    visit("near_rotation_step", near_rotation_step);
    visit("wide_rotation_step", wide_rotation_step);
    visit("translation_penalty", translation_penalty);
    visit("rotation_penalty", rotation_penalty);
    visit("wide_score", wide_score);
    visit("max_insert_score", max_insert_score);
    visit("submap_length", submap_length);
    visit("rebuild_distance", rebuild_distance);
    visit("rebuild_turn", rebuild_turn);
    visit("min_occupancy", min_occupancy);
    visit("keyframe_translation", keyframe_translation);
    visit("keyframe_rotation", keyframe_rotation);
    visit("keyframe_interval", keyframe_interval);
  }
};

/// What tracking a scan gave.
struct TrackingResult {
  /// Best match, to the older active submap; `pose` is T_odom_base.
  MatchResult match;
  bool searched_wide = false;
  bool is_improved = false;  ///< Matched by the points that `improve` gave.
  bool insert = false;       ///< Clean enough to become part of the maps; see `by_wheels` for one that is not usable.
  /// Degenerate, and the maps hold nearly all that it shows: put into them, it would confirm the prediction that placed
  /// it.
  bool adds_nothing = false;
  /// From each active submap that the scan could be matched to. Empty unless the match is usable.
  struct Measurement {
    SubmapId submap;
    SE2 T_submap_base;
    Eigen::Matrix3d information;
  };
  std::vector<Measurement> measurements;
};

/// Matches scans to the two active submaps, which overlap by half (after Hess et al. 2016), and grows these.
class Tracker {
 public:
  Tracker(const TrackerOptions& options, const OccupancyGridOptions& grid, double max_distance, const Matcher& matcher);

  /// The points [m, base frame] of a scan, which depend on its pose.
  using PointsAt = std::function<const std::vector<Eigen::Vector2f>&(const SE2& T_odom_base)>;

  /// Matches `points` [m, base frame] to the active submaps: near `prediction` (T_odom_base) first and, if that finds
  /// nothing good, in a wide surrounding of `last_pose`, the pose of the scan before, since what went wrong is most
  /// likely the prediction. Without submaps the verdict is `kTooFewPoints`.
  /// @param knows_velocity false: `prediction` takes a robot to stand that may well drive, as at a run's second scan;
  ///                       it is searched for in all of the wide translation, without preferring to stand.
  /// @param sigma          standard deviations [m, m, rad] of the prediction, see `MotionFilter`: the first search goes
  ///                       no farther than needed.
  /// @param by_wheels      `prediction` is measured. Then the second search goes around it as well, and no farther than
  ///                       the near window's greatest size, growing as above: farther off, only another place would
  ///                       match. A scan most of which meets nothing known shows new ground, as behind a corner, and is
  ///                       put into the maps where it is predicted.
  /// @param improve        what the scan's points [m, base frame] are if its pose, T_odom_base, is the given one; asked
  ///                       once, with the match's pose, from where these points, which must stay until the end of the
  ///                       call, are matched again. Null: the same.
  TrackingResult Track(const std::vector<Eigen::Vector2f>& points, const SE2& last_pose, const SE2& prediction,
                       bool knows_velocity = true, const Eigen::Vector3d& sigma = Eigen::Vector3d::Ones(),
                       bool by_wheels = false, const PointsAt& improve = nullptr);

  /// True if a scan at `pose` is far enough in space or time from the last keyframe to become one itself.
  bool IsKeyframe(const StampedPose& last_keyframe, const StampedPose& pose) const;

  /// Adds a keyframe's scan to the active submaps; begins a submap at `T_odom_base` when it is time. Returns the submap
  /// that this scan completed, if any.
  /// @param max_length [m], that a submap's path may have where the options allow more.
  std::optional<Submap> Insert(KeyframeId id, const PlanarScan& scan, const SE2& T_odom_base,
                               double max_length = std::numeric_limits<double>::infinity());

  /// Ids of the active submaps, the older first.
  std::vector<SubmapId> ActiveSubmaps() const;
  /// Pose of an active submap, T_odom_submap.
  const SE2& SubmapPose(SubmapId id) const;
  void SetSubmapPose(SubmapId id, const SE2& T_odom_submap);

  /// Takes the active submaps as they are, for the end of a run; no scan can be tracked afterwards.
  std::vector<Submap> FinishAll();

  /// What it remembers of the scans, but for their points: after reading, call `RestoreMaps`.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    uint64_t num_active = active_.size();
    visit(num_lost_, num_submaps_, num_active);
    if constexpr (std::decay_t<Visitor>::kIsReading) {
      visit.Check(num_active <= 2, "more than two submaps are active");
      active_.clear();
      while (active_.size() < num_active) active_.emplace_back(SubmapId(), SE2(), grid_options_);
    }
    for (ActiveSubmap& submap : active_) submap.VisitState(visit);
  }
  /// Puts the scans into the active submaps again, at the poses at which they were inserted; `scan_of` gives those of
  /// the keyframes that the submaps name, and what scans are matched to is afterwards the same bits as it was.
  /// False, for a state that is damaged, when there is no such keyframe (null).
  bool RestoreMaps(const std::function<std::shared_ptr<const PlanarScan>(KeyframeId)>& scan_of);

 private:
  struct ActiveSubmap {
    ActiveSubmap(SubmapId submap_id, const SE2& pose, const OccupancyGridOptions& grid_options)
        : id(submap_id), T_odom_submap(pose), grid(grid_options) {}

    SubmapId id;
    SE2 T_odom_submap;
    OccupancyGrid grid;
    std::vector<KeyframeId> keyframes;
    std::vector<SE2> inserted_at;  // T_submap_base of each of these, when it was inserted.
    double length = 0.0;           // [m] of path.
    SE2 T_submap_last;             // Pose of the scan last inserted.
    // What scans are matched to: the cells within `target_reach` [m] of `target_center`, as of `target_keyframes`
    // scans.
    std::unique_ptr<MatchTarget> target;
    Eigen::Vector2d target_center = Eigen::Vector2d::Zero();
    double target_reach = 0.0;
    size_t target_keyframes = 0;
    double target_length = 0.0;  // `length` then.
    double turn = 0.0;           // [rad] of the path.
    double target_turn = 0.0;    // `turn` then.

    template <class Visitor>
    void VisitState(Visitor&& visit) {
      uint64_t num_in_target = target_keyframes;
      visit(id, T_odom_submap, keyframes, inserted_at, length, T_submap_last, target_center, target_reach,
            num_in_target, target_length, turn, target_turn);
      target_keyframes = static_cast<size_t>(num_in_target);
    }
  };

  // Whether a submap's target must be built anew for scans that reach `reach` [m] around `T_submap_base`: since it does
  // not cover them or, unless it `may_wait`, because too much was put into the submap since.
  bool IsOutdated(const ActiveSubmap& submap, const SE2& T_submap_base, double reach, bool may_wait) const;
  // Builds the target for such scans, and from the submap's map as it is.
  void BuildTarget(const SE2& T_submap_base, double reach, ActiveSubmap* submap) const;
  void MakeTarget(ActiveSubmap* submap) const;
  Submap Finish(ActiveSubmap* active) const;

  TrackerOptions options_;
  OccupancyGridOptions grid_options_;
  float min_log_odds_;
  double max_distance_;
  Matcher matcher_;
  std::deque<ActiveSubmap> active_;
  int num_lost_ = 0;  // Scans in a row that found nothing.
  int num_submaps_ = 0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_TRACKING_TRACKER_H_
