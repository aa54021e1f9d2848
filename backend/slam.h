#ifndef ARBORSLAM_BACKEND_SLAM_H_
#define ARBORSLAM_BACKEND_SLAM_H_

#include <optional>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/slam_options.h"
#include "backend/window/sliding_window.h"
#include "core/map/submap.h"
#include "core/sensor/laser_scan.h"
#include "core/sensor/stamped_pose.h"
#include "frontend/tracking/tracker.h"

namespace arborslam {

/// What became of one scan.
struct ScanResult {
  double stamp = 0.0;   ///< [s], the middle of the sweep.
  SE2 T_odom_base;      ///< The window's estimate when the scan came.
  MatchVerdict verdict = MatchVerdict::kAccepted;
  MatchResult match;
  bool searched_wide = false;
  bool is_keyframe = false;
  double milliseconds = 0.0;  ///< Frontend and window.
};

/// The whole method. Scans go in one at a time, in the order of their stamps; `Finish` closes loops and optimises.
class Slam {
 public:
  /// @param num_threads for loop closure and optimisation; results do not depend on it.
  Slam(const SlamOptions& options, int num_threads);

  ScanResult AddScan(const LaserScan& scan);

  /// Closes loops, optimises the graph, and refines it against the corrected map.
  void Finish(bool odometry_only);

  Trajectory OptimizedTrajectory() const;
  const std::vector<ScanResult>& scans() const { return scans_; }
  const std::vector<LoopCandidate>& loops() const { return loops_; }
  const PoseGraph& graph() const { return graph_; }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const std::vector<Submap>& submaps() const { return submaps_; }

 private:
  SE2 Predict(double stamp) const;
  SE2 AddKeyframe(const PlanarScan& scan, const SE2& prediction, const TrackingResult& tracked);
  void TrimWindow();

  SlamOptions options_;
  int num_threads_;
  Matcher matcher_;
  Tracker tracker_;
  SlidingWindow window_;
  PoseGraph graph_;
  std::vector<Keyframe> keyframes_;
  std::vector<Submap> submaps_;
  std::vector<ScanResult> scans_;
  std::vector<LoopCandidate> loops_;
  std::vector<KeyframeId> scan_keyframe_;
  std::vector<SE2> T_keyframe_scan_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_SLAM_H_
