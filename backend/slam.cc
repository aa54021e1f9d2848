#include "backend/slam.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "backend/refine/map_refiner.h"
#include "core/stopwatch.h"

namespace arborslam {
namespace {

// Information [1/m^2, 1/rad^2] that ties the first keyframe to the odometry frame's origin, and a submap to the
// keyframe that begins it: a tenth of a millimetre.
constexpr double kAnchorInformation = 1e8;

}  // namespace

Slam::Slam(const SlamOptions& options, int num_threads)
    : options_(options),
      num_threads_(num_threads),
      matcher_(options.matcher, options.mhd, options.refinement),
      tracker_(options.tracker, options.grid, options.matcher.max_distance, matcher_) {
  CHECK_GE(num_threads, 1);
}

ScanResult Slam::AddScan(const LaserScan& scan) {
  ScanResult result;
  result.stamp = scan.stamp;
  if (!scans_.empty() && scan.stamp <= scans_.back().stamp) {
    result.reason = "stamp not after the scan before";
    return result;
  }
  Stopwatch stopwatch;
  const PlanarScan planar = ProjectLaserScan(scan, options_.projection);
  result.project_ms = stopwatch.Lap();
  const bool is_first = keyframes_.empty();
  if (is_first && static_cast<int>(planar.points.size()) < options_.matcher.min_points) {
    result.reason = ToString(MatchVerdict::kTooFewPoints);
    return result;
  }

  const SE2 prediction = Predict(scan.stamp);
  const SE2 last_pose = is_first ? SE2() : WindowPose(scans_.back()).pose;
  const TrackingResult tracked = tracker_.Track(planar.points, last_pose, prediction);
  result.match = tracked.match;
  result.searched_wide = tracked.searched_wide;
  result.status = is_first || IsUsable(tracked.match.verdict) ? ScanStatus::kMatched : ScanStatus::kPredicted;
  if (result.status == ScanStatus::kPredicted) result.reason = ToString(tracked.match.verdict);
  result.match_ms = stopwatch.Lap();

  result.is_keyframe =
      is_first || tracker_.IsKeyframe({keyframes_.back().scan.stamp, graph_.Pose(keyframes_.back().id)},
                                      {scan.stamp, tracked.match.pose});
  if (!result.is_keyframe) {
    const KeyframeId last = keyframes_.back().id;
    result.T_odom_base = tracked.match.pose;
    scans_.push_back({scan.stamp, last, window_.Pose(last).Inverse() * result.T_odom_base});
    return result;
  }
  result.T_odom_base = Smooth(planar, prediction, tracked);
  result.is_inserted = keyframes_.back().is_inserted;
  result.window_ms = stopwatch.Lap();
  scans_.push_back({scan.stamp, keyframes_.back().id, SE2()});
  if (result.is_inserted) InsertIntoSubmaps();
  result.insert_ms = stopwatch.Lap();
  TrimWindow();
  result.window_ms += stopwatch.Lap();
  return result;
}

StampedPose Slam::WindowPose(const PosedScan& scan) const {
  return {scan.stamp, window_.Pose(scan.keyframe) * scan.T_keyframe_scan};
}

SE2 Slam::Predict(double stamp) const {
  if (scans_.empty()) return SE2();
  if (scans_.size() == 1) return WindowPose(scans_.back()).pose;
  return PredictPose(WindowPose(scans_[scans_.size() - 2]), WindowPose(scans_.back()), stamp, options_.motion);
}

SE2 Slam::Smooth(const PlanarScan& scan, const SE2& prediction, const TrackingResult& tracked) {
  const KeyframeId id{static_cast<int>(keyframes_.size())};
  const bool is_first = keyframes_.empty();
  window_.AddNode(id, tracked.match.pose);
  graph_.AddNode(id, tracked.match.pose);
  const auto add = [this](const Constraint& constraint) {
    window_.AddConstraint(constraint);
    graph_.AddConstraint(constraint);
  };
  if (is_first) {
    window_.AddPrior(id, kAnchorInformation * Eigen::Matrix3d::Identity());
  } else {
    const KeyframeId last = keyframes_.back().id;
    add({last, id, window_.Pose(last).Inverse() * prediction, MotionInformation(options_.motion),
         Constraint::Kind::kMotion});
  }
  for (const TrackingResult::Measurement& measurement : tracked.measurements) {
    add({measurement.submap, id, measurement.T_submap_base, measurement.information, Constraint::Kind::kSubmap});
  }
  keyframes_.push_back({id, scan, is_first || tracked.insert});

  window_.Solve();
  for (const auto& [node, pose] : window_.poses()) graph_.SetPose(node, pose);
  for (const SubmapId submap : tracker_.ActiveSubmaps()) tracker_.SetSubmapPose(submap, window_.Pose(submap));
  return window_.Pose(id);
}

void Slam::InsertIntoSubmaps() {
  const Keyframe& keyframe = keyframes_.back();
  std::optional<Submap> finished = tracker_.Insert(keyframe.id, keyframe.scan, window_.Pose(keyframe.id));
  if (finished) submaps_.push_back(std::move(*finished));
  for (const SubmapId submap : tracker_.ActiveSubmaps()) {
    if (window_.Has(submap)) continue;
    const Constraint anchor{submap, keyframe.id, SE2(), kAnchorInformation * Eigen::Matrix3d::Identity(),
                            Constraint::Kind::kSubmap};
    window_.AddNode(submap, tracker_.SubmapPose(submap));
    window_.AddConstraint(anchor);
    graph_.AddNode(submap, tracker_.SubmapPose(submap));
    graph_.AddConstraint(anchor);
  }
}

void Slam::TrimWindow() {
  const KeyframeId too_old{static_cast<int>(keyframes_.size()) - options_.window.num_keyframes - 1};
  if (window_.Has(too_old)) window_.Marginalize(too_old);
  const std::vector<SubmapId> active = tracker_.ActiveSubmaps();
  std::vector<NodeId> finished;
  for (const auto& [node, pose] : window_.poses()) {
    const bool is_active =
        std::any_of(active.begin(), active.end(), [id = node](SubmapId a) { return NodeId(a) == id; });
    if (node.kind == NodeId::Kind::kSubmap && !is_active) finished.push_back(node);
  }
  for (const NodeId node : finished) window_.Marginalize(node);
}

FinishResult Slam::Finish(bool odometry_only) {
  FinishResult result;
  for (Submap& submap : tracker_.FinishAll()) submaps_.push_back(std::move(submap));
  if (odometry_only || keyframes_.empty()) return result;

  Stopwatch stopwatch;
  const LoopCloser closer(options_.loop, options_.matcher, matcher_, options_.grid.cell_size);
  result.loops = closer.FindAll(graph_, keyframes_, submaps_, num_threads_);
  for (const LoopCandidate& loop : result.loops) {
    if (!loop.accepted) continue;
    graph_.AddConstraint(
        {loop.submap, loop.keyframe, loop.match.pose, loop.match.information, Constraint::Kind::kLoop});
  }
  result.loop_ms = stopwatch.Lap();
  result.loop_optimization = graph_.Optimize(options_.graph, num_threads_);
  result.optimize_ms = stopwatch.Lap();

  const MapRefiner refiner(options_.map_refinement, options_.grid, options_.tracker.min_occupancy,
                           options_.matcher.max_distance, matcher_);
  for (int pass = 0; pass < options_.map_refinement.num_passes; ++pass) {
    graph_ = refiner.Remeasure(graph_, keyframes_, &submaps_, num_threads_);
    result.refine_ms += stopwatch.Lap();
    result.refinements.push_back(graph_.Optimize(options_.graph, num_threads_));
    result.optimize_ms += stopwatch.Lap();
  }
  return result;
}

Trajectory Slam::OptimizedTrajectory() const {
  Trajectory trajectory;
  trajectory.reserve(scans_.size());
  for (const PosedScan& scan : scans_) {
    trajectory.push_back({scan.stamp, graph_.Pose(scan.keyframe) * scan.T_keyframe_scan});
  }
  return trajectory;
}

OccupancyGrid Slam::BuildMap() const {
  OccupancyGrid map(options_.grid);
  for (const Keyframe& keyframe : keyframes_) {
    if (keyframe.is_inserted) map.Insert(graph_.Pose(keyframe.id), keyframe.scan);
  }
  return map;
}

}  // namespace arborslam
