#include "backend/slam.h"

#include <chrono>
#include <algorithm>

#include "backend/refine/map_refiner.h"

namespace arborslam {

std::string WindowOptions::Validate() const { return ""; }

Slam::Slam(const SlamOptions& options, int num_threads)
    : options_(options),
      num_threads_(num_threads),
      matcher_(options.matcher, options.mhd, options.refinement),
      tracker_(options.tracker, options.grid, options.matcher.max_distance, matcher_) {}

SE2 Slam::Predict(double stamp) const {
  const size_t n = scans_.size();
  if (n == 0) return SE2();
  // Use window's present poses of the last two scans.
  const auto pose = [&](size_t i) {
    return StampedPose{scans_[i].stamp, window_.Pose(scan_keyframe_[i]) * T_keyframe_scan_[i]};
  };
  if (n == 1) return pose(0).pose;
  if (!window_.Has(scan_keyframe_[n - 2])) return pose(n - 1).pose;
  return PredictPose(pose(n - 2), pose(n - 1), stamp, options_.motion);
}

ScanResult Slam::AddScan(const LaserScan& scan) {
  const auto start = std::chrono::steady_clock::now();
  const PlanarScan planar = ProjectLaserScan(scan, options_.projection);
  const SE2 prediction = Predict(scan.stamp);
  const TrackingResult tracked = tracker_.Track(planar.points, scans_.empty() ? SE2() : window_.Pose(scan_keyframe_.back()) * T_keyframe_scan_.back(), prediction);

  ScanResult result;
  result.stamp = scan.stamp;
  result.match = tracked.match;
  result.verdict = tracked.match.verdict;
  result.searched_wide = tracked.searched_wide;
  result.is_keyframe = keyframes_.empty();
  if (!result.is_keyframe) {
    const KeyframeId last = keyframes_.back().id;
    result.is_keyframe =
        tracker_.IsKeyframe({keyframes_.back().scan.stamp, window_.Pose(last)}, {scan.stamp, tracked.match.pose});
  }
  if (result.is_keyframe) {
    result.T_odom_base = AddKeyframe(planar, prediction, tracked);
    scan_keyframe_.push_back(keyframes_.back().id);
    T_keyframe_scan_.push_back(SE2());
  } else {
    const KeyframeId last = keyframes_.back().id;
    result.T_odom_base = tracked.match.pose;
    scan_keyframe_.push_back(last);
    T_keyframe_scan_.push_back(window_.Pose(last).Inverse() * result.T_odom_base);
  }
  if (keyframes_.size() == 1) result.verdict = MatchVerdict::kAccepted;
  result.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  scans_.push_back(result);
  return result;
}

SE2 Slam::AddKeyframe(const PlanarScan& scan, const SE2& prediction, const TrackingResult& tracked) {
  const KeyframeId id{static_cast<int>(keyframes_.size())};
  keyframes_.push_back({id, scan, false});
  Keyframe& keyframe = keyframes_.back();
  window_.AddNode(id, tracked.match.pose);
  std::vector<Constraint> constraints;
  if (id.value == 0) {
    window_.AddPrior(id, 1e8 * Eigen::Matrix3d::Identity());
    keyframe.inserted = true;
  } else {
    const KeyframeId last{id.value - 1};
    const double t = options_.motion.translation_sigma;
    const double r = options_.motion.rotation_sigma;
    constraints.push_back({last, id, window_.Pose(last).Inverse() * prediction,
                           Eigen::Vector3d(1 / (t * t), 1 / (t * t), 1 / (r * r)).asDiagonal(), Constraint::Kind::kMotion});
    for (const auto& m : tracked.measurements) {
      constraints.push_back({m.submap, id, m.T_submap_base, m.information, Constraint::Kind::kSubmap});
    }
    keyframe.inserted = tracked.insert;
  }
  for (const Constraint& c : constraints) window_.AddConstraint(c);
  window_.Solve();
  for (SubmapId submap : tracker_.ActiveSubmaps()) tracker_.SetSubmapPose(submap, window_.Pose(submap));

  graph_.AddNode(id, window_.Pose(id));
  if (keyframe.inserted) {
    if (auto done = tracker_.Insert(id, scan, window_.Pose(id))) submaps_.push_back(*done);
    for (SubmapId submap : tracker_.ActiveSubmaps()) {
      if (window_.Has(submap)) continue;
      window_.AddNode(submap, tracker_.SubmapPose(submap));
      graph_.AddNode(submap, tracker_.SubmapPose(submap));
      Constraint anchor{submap, id, SE2(), 1e8 * Eigen::Matrix3d::Identity(), Constraint::Kind::kSubmap};
      window_.AddConstraint(anchor);
      constraints.push_back(anchor);
    }
  }
  for (const Constraint& c : constraints) graph_.AddConstraint(c);
  TrimWindow();
  return window_.Pose(id);
}

void Slam::TrimWindow() {
  const int oldest = static_cast<int>(keyframes_.size()) - options_.window.num_keyframes;
  if (oldest > 0 && window_.Has(KeyframeId{oldest - 1})) window_.Marginalize(KeyframeId{oldest - 1});
  // Finished submaps
  const auto active = tracker_.ActiveSubmaps();
  std::vector<NodeId> gone;
  for (const auto& [node, pose] : window_.poses()) {
    if (node.kind == NodeId::Kind::kSubmap &&
        std::none_of(active.begin(), active.end(), [n = node](SubmapId a) { return NodeId(a) == n; }))
      gone.push_back(node);
  }
  for (NodeId n : gone) window_.Marginalize(n);
}

void Slam::Finish(bool odometry_only) {
  for (Submap& submap : tracker_.FinishAll()) submaps_.push_back(std::move(submap));
  graph_.Optimize(options_.graph, num_threads_);
  if (odometry_only) return;
  const LoopCloser closer(options_.loop, options_.matcher, matcher_, options_.grid.cell_size);
  loops_ = closer.FindAll(graph_, keyframes_, submaps_, num_threads_);
  for (const LoopCandidate& c : loops_) {
    if (c.accepted) graph_.AddConstraint({c.submap, c.keyframe, c.match.pose, c.match.information, Constraint::Kind::kLoop});
  }
  graph_.Optimize(options_.graph, num_threads_);
  const MapRefiner refiner(options_.map_refinement, options_.grid, options_.tracker.min_occupancy,
                           options_.matcher.max_distance, matcher_);
  for (int pass = 0; pass < options_.map_refinement.num_passes; ++pass) {
    graph_ = refiner.Remeasure(graph_, keyframes_, &submaps_, num_threads_);
    graph_.Optimize(options_.graph, num_threads_);
  }
}

Trajectory Slam::OptimizedTrajectory() const {
  Trajectory trajectory;
  for (size_t i = 0; i < scans_.size(); ++i) {
    trajectory.push_back({scans_[i].stamp, graph_.Pose(scan_keyframe_[i]) * T_keyframe_scan_[i]});
  }
  return trajectory;
}

}  // namespace arborslam
