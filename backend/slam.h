#ifndef ARBORSLAM_BACKEND_SLAM_H_
#define ARBORSLAM_BACKEND_SLAM_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/global_solution.h"
#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/posed_scan.h"
#include "backend/run_verdict.h"
#include "backend/scan_result.h"
#include "backend/slam_options.h"
#include "backend/store/session_contents.h"
#include "backend/window/sliding_window.h"
#include "core/io/value_store.h"
#include "core/map/occupancy_grid.h"
#include "core/map/submap.h"
#include "core/sensor/laser_scan.h"
#include "core/sensor/lidar_sweep.h"
#include "core/sensor/stamped_pose.h"
#include "core/sensor/trajectory3.h"
#include "frontend/tracking/motion_filter.h"
#include "frontend/tracking/sweep_duration.h"
#include "frontend/tracking/sweep_reducer.h"
#include "frontend/tracking/tracker.h"
#include "frontend/tracking/wheel_odometry.h"

namespace arborslam {

/// How long the sweeps of a recording last that does not tell (`LidarSweep::is_duration_guessed`).
struct SweepDurationResult {
  double seconds = 0.0;
  bool is_found = false;  ///< From the motion; false: that did not tell, `seconds` is the guess of the sweeps.
  SweepDurationEstimate estimate;
  /// [s], by how much stamps of poses are later than `ScanResult` said, for the middles of the sweeps lie elsewhere.
  double stamp_shift = 0.0;
};

/// What the end of an offline run did.
struct FinishResult : GlobalSolution {
  std::vector<PoseSource> pose_sources;               ///< One for each of `Slam::scans`.
  std::vector<MapSegment> segments;                   ///< In their order; one when tracking was never lost.
  std::optional<SweepDurationResult> sweep_duration;  ///< Nothing when the sweeps told it.
  double terrain_ms = 0.0;                            ///< [ms], heights and tilts.
};

/// Lidar-only SLAM in the plane (design section 3): scans go in one at a time, each is matched to the active submaps
/// and smoothed in a sliding window; `Finish` closes loops, optimises the graph and refines it against the corrected
/// map. Sweeps in space are first stood upright and projected; their heights and tilts are smoothed over the terrain at
/// the end. A sweep's duration that is a guess is found from the motion: deskewing goes by it as soon as it is known,
/// the stamps of poses at the end. For one thread; equal inputs and options give equal results to the last bit,
/// whatever `num_threads`.
class Slam {
 public:
  /// @param options     valid ones, see the sections' `Validate`.
  /// @param num_threads for `Finish`, at least 1.
  /// @param store       takes care of scans and submaps; null: they are kept in memory. The results are the same.
  Slam(const SlamOptions& options, int num_threads, std::shared_ptr<ValueStore> store = nullptr);
  /// Goes on with a run where `contents`, of an unfinished session, ends: scans that follow, and the end of the run,
  /// give the same bits as if it had never been interrupted. `options` must be the session's. Throws `UserError`,
  /// naming `place`, when the parts of `contents` do not go together.
  Slam(const SlamOptions& options, int num_threads, SessionContents contents, const std::string& place,
       std::shared_ptr<ValueStore> store = nullptr);

  /// Takes the next scan. A scan that is not later than the one before is skipped, and so are scans with too few points
  /// before the first map is begun.
  ScanResult AddScan(const LaserScan& scan);
  /// The same for a sweep in space. A run takes scans of one kind only.
  ScanResult AddScan(const LidarSweep& sweep);

  /// Ends the run; no scan may follow. Stamps of poses are those of the sweeps' real middles from here on. With
  /// `odometry_only` no loops are closed and nothing is matched again.
  FinishResult Finish(bool odometry_only);

  /// Poses T_map_base of all scans that were not skipped: after `Finish` the optimised ones, before it the window's.
  Trajectory OptimizedTrajectory() const;
  /// The same in space, T_map_lidar: z = 0 is the ground where the run began. Level poses at z = 0 for planar scans.
  Trajectory3 OptimizedTrajectory3() const;

  /// All clean scans at their present poses, in the map frame. Needs at least one.
  /// @param cell_size [m]; 0: that of the maps that scans are matched to.
  OccupancyGrid BuildMap(double cell_size = 0.0) const;

  const PoseGraph& graph() const { return graph_; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<Submap>& submaps() const { return submaps_; }
  const std::vector<PosedScan>& scans() const { return scans_; }
  const SlidingWindow& window() const { return window_; }

  /// What a run that goes on later needs besides its scans, keyframes, finished submaps and graph: of bounded size.
  std::string SaveState() const;

 private:
  // What `SaveState` holds.
  template <class Self, class Archive>
  static void VisitState(Self* slam, Archive* archive) {
    (*archive)(slam->window_, slam->tracker_, slam->reducer_, slam->motion_, slam->duration_estimator_,
               slam->duration_guess_, slam->duration_);
  }
  // The sizes of all that a state goes with.
  std::array<uint64_t, 5> Sizes() const;

  // True, with a reason, for a scan that comes too late.
  bool IsOutOfOrder(ScanResult* result) const;
  // Where a scan is taken to be before it is matched.
  struct Prediction {
    SE2 pose;                                // T_odom_base.
    Eigen::Vector3d sigma;                   // [m, m, rad], its standard deviations,
    Eigen::Vector3d step_sigma;              // and those of the step from the last keyframe.
    bool knows_velocity;                     // False: it takes a robot to stand that may well drive.
    std::optional<OdometryStep> since_scan;  // Of the wheels, on which it then rests.
    std::optional<OdometryStep> since_keyframe;
  };
  // By the wheels where there are any, else by the motion model.
  Prediction PredictScan(double stamp, const std::optional<SE2>& odometry) const;
  // A scan that depends on its pose, by which it can be matched again.
  struct Improvement {
    Tracker::PointsAt points;  // As `Tracker::Track` has it,
    const PlanarScan* scan;    // and the scan that those points are of.
  };
  // Tracks a scan from `prediction`: fills the rest of `result`. `to_match` [m, base frame]: those of its points by
  // which it is matched. Returns whether the improved scan was taken for it; `improvement` null: there is none.
  bool AddPlanarScan(const PlanarScan& planar, const std::vector<Eigen::Vector2f>& to_match,
                     const Prediction& prediction, const Improvement* improvement, ScanResult* result);
  // Learns from a sweep how long sweeps last.
  void AddToDuration(const LidarSweep& sweep, const ReducedSweep& reduced, const ScanResult& result);
  // Tracks scans that were lost backwards in the map that follows them.
  void RecoverLost();
  // Interpolates the poses of scans that were not measured, and finds the segments of the run.
  void PlaceUnmeasured(FinishResult* result);
  void InterpolateBetween(size_t before, size_t after);
  // True if the scan became a keyframe; others hang on the keyframe before.
  bool IsKeyframe(size_t scan) const;
  // Settles how long sweeps last, if they did not tell, and shifts all stamps accordingly.
  std::optional<SweepDurationResult> FinishDuration();

  // The window's present estimate of a scan's pose, T_odom_base; its keyframe must be in the window.
  StampedPose WindowPose(const PosedScan& scan) const;
  // Makes the scan a variable of window and graph, with all that was measured about it; returns its smoothed pose.
  // @param begins_map the scan is the first of a new map: nothing is measured from the scans before it.
  SE2 Smooth(const PlanarScan& scan, const Prediction& prediction, const TrackingResult& tracked, bool begins_map);
  // Takes how a scan fits the present map, without wheel odometry.
  void CountForLoss(bool begins_map, bool is_rejected, bool is_clean);
  // True when so many scans in a row were rejected that the next one is to begin a new map.
  bool IsLost() const;
  // Ends the active submaps, in which nothing is found any more: the present scan begins a new map.
  void BeginMap();
  // Finds how many scans were rejected last, and where the present map began, from the results of all scans.
  void RestoreLoss(const std::vector<SessionContents::ReadScan>& read);
  // Puts the latest keyframe's scan into the active submaps, and new submaps into window and graph.
  void InsertIntoSubmaps();
  // Takes a submap that is finished.
  void AddSubmap(Submap submap);
  // Marginalises what is too old for the window.
  void TrimWindow();

  SlamOptions options_;
  int num_threads_;
  std::shared_ptr<ValueStore> store_;
  Matcher matcher_;
  SweepReducer reducer_;
  MotionFilter motion_;
  WheelOdometry wheels_;
  Tracker tracker_;
  SlidingWindow window_;
  PoseGraph graph_;
  std::vector<Keyframe> keyframes_;
  std::vector<Submap> submaps_;  // Finished ones.
  std::vector<PosedScan> scans_;
  int num_clean_ = 0;               // Scans that the present map took, with the one that began it.
  int num_unclean_ = 0;             // Scans in a row that it did not take.
  int num_rejected_ = 0;            // Scans in a row that the active submaps rejected.
  std::vector<char> was_matched_;   // By scan: it was when it came.
  std::vector<size_t> map_begins_;  // Indices into `scans_` of those that began a new map when tracking was lost.
  SweepDurationEstimator duration_estimator_;  // For sweeps whose duration is a guess.
  // What these sweeps say of themselves.
  struct DurationGuess {
    double seconds;
    double stamp_phase;

    template <class Visitor>
    void VisitState(Visitor&& visit) {
      visit(seconds, stamp_phase);
    }
  };
  std::optional<DurationGuess> duration_guess_;
  double duration_ = 0.0;  // [s], that they are taken to last at present.
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_SLAM_H_
