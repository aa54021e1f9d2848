#include "backend/slam.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "backend/graph/map_parts.h"
#include "backend/loop/lost_scans.h"
#include "backend/run_outputs.h"
#include "backend/terrain/scan_tilts.h"
#include "core/io/binary_archive.h"
#include "core/stopwatch.h"

namespace arborslam {
namespace {

// Information [1/m^2, 1/rad^2] that ties the first keyframe to the odometry frame's origin, and a submap to the
// keyframe that begins it: a tenth of a millimetre.
constexpr double kAnchorInformation = 1e8;
// Standard deviations [m] and [rad] of a gap: the robot may have been carried anywhere. They only keep the graph whole.
const Eigen::Vector3d kGapSigma(100.0, 100.0, 10.0);
// Scans in a row that the map rejects before the next one begins a new map.
constexpr int kMaxRejected = 5;
// A map of no more clean scans than this may have begun badly: one that does not take so many scans in a row is left.
constexpr int kYoungMap = 10;
constexpr int kMaxUnclean = 3;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

// The mean of a prediction with standard deviations `sigma` [m, m, rad] and of the match, each counting as it knows.
SE2 Fuse(const SE2& prediction, const Eigen::Vector3d& sigma, const MatchResult& match) {
  if (!IsUsable(match.verdict)) return prediction;
  const Eigen::Matrix3d information = match.information + MotionInformation(sigma);
  const Eigen::Vector3d error = (prediction.Inverse() * match.pose).vector();
  const Eigen::Vector3d correction = information.ldlt().solve(match.information * error);
  return prediction * SE2(correction.x(), correction.y(), correction.z());
}

}  // namespace

Slam::Slam(const SlamOptions& options, int num_threads, std::shared_ptr<ValueStore> store)
    : options_(options),
      num_threads_(num_threads),
      store_(std::move(store)),
      matcher_(options.matcher, options.mhd, options.refinement),
      reducer_(options.reduction, options.sweep, options.dynamic, options.compact, options.terrain.cell_size),
      motion_(options.motion),
      wheels_(options.odometry),
      tracker_(options.tracker, options.grid, options.matcher.max_distance, matcher_) {
  CHECK_GE(num_threads, 1);
}

Slam::Slam(const SlamOptions& options, int num_threads, SessionContents contents, const std::string& place,
           std::shared_ptr<ValueStore> store)
    : Slam(options, num_threads, std::move(store)) {
  graph_ = std::move(contents.graph);
  keyframes_ = std::move(contents.keyframes);
  submaps_ = std::move(contents.submaps);
  scans_ = std::move(contents.scans);
  if (contents.read.empty()) return;
  BinaryReader state(contents.state, place);
  std::array<uint64_t, 5> sizes{};
  state(sizes);
  state.Check(sizes == Sizes(), "its tables are not of one moment");
  VisitState(this, &state);
  if (!state.AtEnd()) state(wheels_);
  state.CheckEnd();
  for (const auto& [node, pose] : window_.poses()) {
    state.Check(graph_.poses().count(node) > 0, "the window has a pose that the graph lacks");
  }
  for (const SubmapId submap : tracker_.ActiveSubmaps()) {
    state.Check(window_.Has(submap), "a submap that grows is not in the window");
  }
  for (size_t i = scans_.size() - std::min<size_t>(2, scans_.size()); i < scans_.size(); ++i) {
    state.Check(window_.Has(scans_[i].keyframe), "the last scans are not in the window");
  }
  RestoreLoss(contents.read);
  const bool has_scans = tracker_.RestoreMaps([this](KeyframeId id) {
    const bool exists = id.value >= 0 && static_cast<size_t>(id.value) < keyframes_.size();
    return exists ? keyframes_[static_cast<size_t>(id.value)].scan.Get() : nullptr;
  });
  state.Check(has_scans, "a submap that grows has a keyframe that does not exist");
  auto scan = scans_.begin();
  const auto first_of_map = scans_.begin() + static_cast<std::ptrdiff_t>(map_begins_.empty() ? 0 : map_begins_.back());
  for (const SessionContents::ReadScan& read : contents.read) {
    if (read.result.status == ScanStatus::kSkipped) continue;
    state.Check(scan != scans_.end(), "a scan has no pose");
    if (read.result.has_ground && scan >= first_of_map)
      reducer_.AddTerrain(*scan->ground.Get(), read.result.T_odom_base, scan->tilt);
    ++scan;
  }
}

void Slam::RestoreLoss(const std::vector<SessionContents::ReadScan>& read) {
  size_t num_posed = 0;
  for (const SessionContents::ReadScan& scan : read) {
    if (scan.result.status == ScanStatus::kSkipped) continue;
    const bool was_matched = scan.result.status == ScanStatus::kMatched;
    const bool begins_map = num_posed > 0 && was_matched && !IsUsable(scan.result.match.verdict);
    if (begins_map) map_begins_.push_back(num_posed);
    const MatchResult& match = scan.result.match;
    const bool is_rejected = !was_matched && match.num_points >= options_.matcher.min_points;
    const bool begins = num_posed == 0 || begins_map;
    const bool is_clean = IsUsable(match.verdict) && match.score <= options_.tracker.max_insert_score;
    if (!wheels_.has_odometry() && match.num_points >= options_.matcher.min_points) {
      CountForLoss(begins, is_rejected, begins || is_clean);
    }
    was_matched_.push_back(scan.result.status == ScanStatus::kMatched ? 1 : 0);
    ++num_posed;
  }
}

std::string Slam::SaveState() const {
  BinaryWriter state;
  state(Sizes());
  VisitState(this, &state);
  // Left out where there are none, as of sessions made before wheels were known.
  if (wheels_.has_odometry()) state(wheels_);
  return state.bytes();
}

std::array<uint64_t, 5> Slam::Sizes() const {
  return {scans_.size(), keyframes_.size(), submaps_.size(), graph_.poses().size(), graph_.constraints().size()};
}

ScanResult Slam::AddScan(const LaserScan& scan) {
  ScanResult result;
  result.stamp = scan.stamp;
  if (IsOutOfOrder(&result)) return result;
  Stopwatch stopwatch;
  const PlanarScan planar = ProjectLaserScan(scan, options_.projection);
  result.project_ms = stopwatch.Lap();
  AddPlanarScan(planar, planar.points, PredictScan(scan.stamp, scan.odometry), nullptr, &result);
  if (result.status != ScanStatus::kSkipped) wheels_.Commit(scan.odometry, result.is_keyframe);
  return result;
}

ScanResult Slam::AddScan(const LidarSweep& sweep) {
  ScanResult result;
  result.stamp = sweep.Middle();
  if (IsOutOfOrder(&result)) return result;
  Stopwatch stopwatch;
  if (IsLost()) reducer_.ForgetPlace();
  const Prediction prediction = PredictScan(result.stamp, std::nullopt);
  // A sweep whose duration is a guess is deskewed as if the robot were as fast as it must be for the way of the real
  // duration.
  double share = 1.0;
  if (sweep.is_duration_guessed && sweep.duration > 0.0) {
    if (!duration_guess_) {
      duration_guess_ = DurationGuess{sweep.duration, sweep.stamp_phase};
      duration_ = sweep.duration;
    }
    share = duration_ / sweep.duration;
  }
  const auto deskewing = [share](const PlanarVelocity& velocity) {
    return PlanarVelocity{share * velocity.linear, share * velocity.angular};
  };
  ReducedSweep reduced = reducer_.Reduce(sweep, prediction.pose, deskewing(motion_.velocity()));
  result.tilt = reduced.tilt;
  result.has_ground = reduced.has_ground;
  result.num_moving = reduced.num_moving;
  result.project_ms = stopwatch.Lap();
  // Until it was matched, only the way to the scan before told how fast the robot is.
  ReducedSweep improved;
  const auto improve = [&](const SE2& T_odom_base) -> const std::vector<Eigen::Vector2f>& {
    improved = reduced;
    const StampedPose here{result.stamp, T_odom_base};
    reducer_.Redeskew(sweep, deskewing(VelocityBetween(WindowPose(scans_.back()), here)), &improved);
    return improved.to_match;
  };
  const Improvement improvement{improve, &improved.planar};
  const bool is_improved = AddPlanarScan(reduced.planar, reduced.to_match, prediction,
                                         reducer_.CanRedeskew(reduced) ? &improvement : nullptr, &result);
  if (is_improved) reduced = std::move(improved);
  if (!sweep.fault.empty() && result.status != ScanStatus::kMatched) result.reason = sweep.fault;
  if (result.status == ScanStatus::kSkipped) return result;
  stopwatch.Lap();
  reducer_.Commit(reduced, result.T_odom_base);
  if (sweep.is_duration_guessed) AddToDuration(sweep, reduced, result);
  PosedScan& scan = scans_.back();
  scan.tilt = reduced.tilt;
  scan.local_tilt = reduced.local_tilt;
  scan.odometry_tilt = reduced.tilt;
  if (result.is_keyframe) scan.lines = {reducer_.LinesOfLast(reduced), store_};
  scan.ground = {std::move(reduced.ground), store_};
  result.insert_ms += stopwatch.Lap();
  return result;
}

bool Slam::IsOutOfOrder(ScanResult* result) const {
  if (scans_.empty() || result->stamp > scans_.back().stamp) return false;
  result->reason = "stamp not after the scan before";
  return true;
}

bool Slam::AddPlanarScan(const PlanarScan& planar, const std::vector<Eigen::Vector2f>& to_match,
                         const Prediction& prediction, const Improvement* improvement, ScanResult* result_out) {
  ScanResult& result = *result_out;
  Stopwatch stopwatch;
  const bool is_first = keyframes_.empty();
  if (is_first && static_cast<int>(to_match.size()) < options_.matcher.min_points) {
    result.reason = ToString(MatchVerdict::kTooFewPoints);
    return false;
  }
  const bool begins_map = IsLost() && static_cast<int>(to_match.size()) >= options_.matcher.min_points;
  if (begins_map) BeginMap();
  const SE2 last_pose = is_first ? SE2() : WindowPose(scans_.back()).pose;
  const TrackingResult tracked =
      tracker_.Track(to_match, last_pose, prediction.pose, prediction.knows_velocity, prediction.sigma,
                     prediction.since_scan.has_value(), improvement != nullptr ? improvement->points : nullptr);
  result.match = tracked.match;
  result.searched_wide = tracked.searched_wide;
  result.status =
      is_first || begins_map || IsUsable(tracked.match.verdict) ? ScanStatus::kMatched : ScanStatus::kPredicted;
  if (result.status == ScanStatus::kPredicted) result.reason = ToString(tracked.match.verdict);
  const bool is_rejected =
      result.status == ScanStatus::kPredicted && static_cast<int>(to_match.size()) >= options_.matcher.min_points;
  // With wheel odometry a robot is where that has it. An empty scan says nothing of the map.
  if (!wheels_.has_odometry() && static_cast<int>(to_match.size()) >= options_.matcher.min_points) {
    CountForLoss(is_first || begins_map, is_rejected, is_first || begins_map || tracked.insert);
  }
  const bool is_clean = tracked.insert && IsUsable(tracked.match.verdict);
  if (is_clean && prediction.since_scan) {
    wheels_.Learn(*prediction.since_scan, last_pose.Inverse() * tracked.match.pose, tracked.match.information);
  }
  if (!is_first && !begins_map) {
    motion_.Add({scans_.back().stamp, last_pose}, {result.stamp, tracked.match.pose},
                IsUsable(tracked.match.verdict) ? tracked.match.information : Eigen::Matrix3d::Zero());
  }
  was_matched_.push_back(result.status == ScanStatus::kMatched ? 1 : 0);
  result.match_ms = stopwatch.Lap();

  // Rejected scans are kept: a later map may tell where they were taken.
  result.is_keyframe = is_first || begins_map || is_rejected ||
                       tracker_.IsKeyframe({keyframes_.back().scan.Get()->stamp, graph_.Pose(keyframes_.back().id)},
                                           {result.stamp, tracked.match.pose});
  if (!result.is_keyframe) {
    const KeyframeId last = keyframes_.back().id;
    result.T_odom_base = Fuse(prediction.pose, prediction.sigma, tracked.match);
    scans_.push_back({result.stamp, last, window_.Pose(last).Inverse() * result.T_odom_base, {}, {}, {}, {}, {}});
    return tracked.is_improved;
  }
  result.T_odom_base = Smooth(tracked.is_improved ? *improvement->scan : planar, prediction, tracked, begins_map);
  result.is_inserted = keyframes_.back().is_inserted;
  result.window_ms = stopwatch.Lap();
  scans_.push_back({result.stamp, keyframes_.back().id, SE2(), {}, {}, {}, {}, {}});
  if (result.is_inserted && !tracked.adds_nothing) InsertIntoSubmaps();
  result.insert_ms = stopwatch.Lap();
  TrimWindow();
  result.window_ms += stopwatch.Lap();
  return tracked.is_improved;
}

void Slam::CountForLoss(bool begins_map, bool is_rejected, bool is_clean) {
  if (begins_map) num_clean_ = 0;
  num_rejected_ = is_rejected ? num_rejected_ + 1 : 0;
  num_clean_ += is_clean ? 1 : 0;
  num_unclean_ = is_clean ? 0 : num_unclean_ + 1;
}

bool Slam::IsLost() const {
  if (wheels_.has_odometry()) return false;
  return num_rejected_ >= kMaxRejected || (num_clean_ <= kYoungMap && num_unclean_ >= kMaxUnclean);
}

void Slam::BeginMap() {
  for (Submap& submap : tracker_.FinishAll()) AddSubmap(std::move(submap));
  motion_ = MotionFilter(options_.motion);
  map_begins_.push_back(scans_.size());
}

StampedPose Slam::WindowPose(const PosedScan& scan) const {
  return {scan.stamp, window_.Pose(scan.keyframe) * scan.T_keyframe_scan};
}

Slam::Prediction Slam::PredictScan(double stamp, const std::optional<SE2>& odometry) const {
  const Eigen::Vector3d most = options_.motion.GreatestSigma();
  Prediction prediction{SE2(),
                        most,
                        most,
                        scans_.size() > (map_begins_.empty() ? 0 : map_begins_.back()) + 1,
                        wheels_.SinceScan(odometry),
                        wheels_.SinceKeyframe(odometry)};
  if (!scans_.empty()) {
    const MotionFilter::Prediction by_motion = motion_.Predict(WindowPose(scans_.back()), stamp);
    prediction.pose = by_motion.pose;
    prediction.sigma = by_motion.sigma;
    // A keyframe's own pose is known to the window; that of a scan in between is not.
    const bool from_keyframe = scans_.back().T_keyframe_scan.vector().isZero(0.0);
    prediction.step_sigma = from_keyframe ? by_motion.step_sigma : by_motion.sigma;
  }
  if (prediction.since_scan) {
    prediction.pose = WindowPose(scans_.back()).pose * prediction.since_scan->motion;
    prediction.sigma = prediction.since_scan->sigma.cwiseMin(options_.motion.GreatestSigma());
    prediction.knows_velocity = true;
  }
  return prediction;
}

SE2 Slam::Smooth(const PlanarScan& scan, const Prediction& prediction, const TrackingResult& tracked, bool begins_map) {
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
    if (prediction.since_keyframe) {
      add({last, id, prediction.since_keyframe->motion, MotionInformation(prediction.since_keyframe->sigma),
           Constraint::Kind::kMotion});
    } else {
      // That a robot stands which may well drive is not worth holding on to.
      const SE2& expected = prediction.knows_velocity ? prediction.pose : tracked.match.pose;
      Constraint motion{last, id, window_.Pose(last).Inverse() * expected, MotionInformation(prediction.step_sigma),
                        Constraint::Kind::kMotion};
      window_.AddConstraint(motion);
      if (begins_map) {
        motion.kind = Constraint::Kind::kGap;
        motion.information = MotionInformation(kGapSigma);
      }
      // It was derived from earlier matches. Over the whole run these say more once they are corrected by later ones,
      // and the motion counts only where the match leaves something open.
      if (tracked.match.verdict == MatchVerdict::kAccepted) {
        motion.information = MotionInformation(options_.motion.GreatestSigma());
      }
      graph_.AddConstraint(motion);
    }
  }
  for (const TrackingResult::Measurement& measurement : tracked.measurements) {
    add({measurement.submap, id, measurement.T_submap_base, measurement.information, Constraint::Kind::kSubmap});
  }
  // Only finding what moves needs the rest, on the sweeps to come; over a run it would be half of the memory.
  PlanarScan kept;
  kept.stamp = scan.stamp;
  kept.points = scan.points;
  kept.free_ends = scan.free_ends;
  kept.point_rays_are_free = scan.point_rays_are_free;
  keyframes_.push_back({id, {std::move(kept), store_}, is_first || begins_map || tracked.insert});

  window_.Solve();
  for (const auto& [node, pose] : window_.poses()) graph_.SetPose(node, pose);
  for (const SubmapId submap : tracker_.ActiveSubmaps()) tracker_.SetSubmapPose(submap, window_.Pose(submap));
  return window_.Pose(id);
}

void Slam::InsertIntoSubmaps() {
  const Keyframe& keyframe = keyframes_.back();
  const double max_length =
      options_.odometry.enabled && wheels_.has_odometry() ? options_.odometry.submap_length : kUnbounded;
  std::optional<Submap> finished =
      tracker_.Insert(keyframe.id, *keyframe.scan.Get(), window_.Pose(keyframe.id), max_length);
  if (finished) AddSubmap(std::move(*finished));
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

void Slam::AddSubmap(Submap submap) {
  submap.cells = submap.cells.MovedTo(store_);
  submaps_.push_back(std::move(submap));
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
  result.sweep_duration = FinishDuration();
  for (Submap& submap : tracker_.FinishAll()) AddSubmap(std::move(submap));
  Stopwatch stopwatch;
  if (!odometry_only) RecoverLost();
  if (odometry_only || keyframes_.empty()) {
    PlaceUnmeasured(&result);
    SmoothTilts(options_.terrain, graph_, &scans_);
    result.terrain_ms = stopwatch.Lap();
    return result;
  }
  static_cast<GlobalSolution&>(result) =
      SolveGlobally(options_, matcher_, num_threads_, keyframes_, &graph_, &submaps_);
  stopwatch.Lap();
  PlaceUnmeasured(&result);
  SmoothTilts(options_.terrain, graph_, &scans_);
  result.terrain_ms = stopwatch.Lap();
  return result;
}

void Slam::RecoverLost() {
  const std::vector<KeyframeId> recovered =
      RecoverLostScans(options_.tracker, matcher_, options_.grid.cell_size, options_.matcher.max_distance, keyframes_,
                       submaps_, &graph_);
  // Scans that the next map has taken over are its own; one that has lost all of them was a start that failed.
  const auto is_taken = [&](size_t i) {
    return std::binary_search(recovered.begin(), recovered.end(), scans_[i].keyframe) || !was_matched_[i];
  };
  size_t begin = 0;
  std::vector<size_t> kept;
  for (const size_t next_begin : map_begins_) {
    size_t end = next_begin;
    while (end > begin && is_taken(end - 1)) --end;
    if (end > begin) kept.push_back(end);
    begin = next_begin;
  }
  map_begins_ = std::move(kept);
}

void Slam::PlaceUnmeasured(FinishResult* result) {
  std::set<NodeId> measured;
  for (const Constraint& constraint : graph_.constraints()) {
    if (IsMatch(constraint)) measured.insert(constraint.to);
  }
  const MapParts parts(graph_);
  result->pose_sources.assign(scans_.size(), PoseSource::kUnknown);
  std::optional<size_t> before;  // The last measured scan.
  for (size_t i = 0; i < scans_.size(); ++i) {
    if (IsKeyframe(i) ? measured.count(scans_[i].keyframe) == 0 : !was_matched_[i]) continue;
    result->pose_sources[i] = PoseSource::kMeasured;
    const size_t part = parts.Of(scans_[i].keyframe);
    const bool is_same = before && parts.Of(scans_[*before].keyframe) == part;
    if (is_same) {
      InterpolateBetween(*before, i);
      std::fill(result->pose_sources.begin() + static_cast<std::ptrdiff_t>(*before) + 1,
                result->pose_sources.begin() + static_cast<std::ptrdiff_t>(i), PoseSource::kInterpolated);
    }
    const auto next_map =
        before ? std::upper_bound(map_begins_.begin(), map_begins_.end(), *before) : map_begins_.end();
    if (is_same && (next_map == map_begins_.end() || *next_map > i)) {
      result->segments.back().last_scan = i;
    } else {
      result->segments.push_back({i, i, part == parts.main_part()});
    }
    before = i;
  }
}

bool Slam::IsKeyframe(size_t scan) const { return scan == 0 || scans_[scan - 1].keyframe < scans_[scan].keyframe; }

void Slam::InterpolateBetween(size_t before, size_t after) {
  const StampedPose from{scans_[before].stamp, graph_.Pose(scans_[before].keyframe) * scans_[before].T_keyframe_scan};
  const StampedPose to{scans_[after].stamp, graph_.Pose(scans_[after].keyframe) * scans_[after].T_keyframe_scan};
  for (size_t i = before + 1; i < after; ++i) {
    const SE2 pose = Interpolate(from.pose, to.pose, (scans_[i].stamp - from.stamp) / (to.stamp - from.stamp));
    if (IsKeyframe(i)) {
      graph_.SetPose(scans_[i].keyframe, pose);
    } else {
      scans_[i].T_keyframe_scan = graph_.Pose(scans_[i].keyframe).Inverse() * pose;
    }
  }
}

void Slam::AddToDuration(const LidarSweep& sweep, const ReducedSweep& reduced, const ScanResult& result) {
  TimedSweep timed;
  timed.stamp = result.stamp;
  timed.points = reduced.planar.points;
  timed.phases = reduced.planar.phases;
  timed.deskewing = reduced.deskewing;
  timed.deskewing_duration = sweep.duration;
  timed.T_odom_base = result.T_odom_base;
  timed.is_matched = result.status == ScanStatus::kMatched && result.match.score <= options_.tracker.max_insert_score;
  if (!duration_estimator_.Add(std::move(timed))) return;
  const std::optional<double> found =
      DecideSweepDuration(duration_estimator_.Estimate(), duration_estimator_.MedianStep());
  if (found) duration_ = *found;
}

std::optional<SweepDurationResult> Slam::FinishDuration() {
  if (!duration_guess_) return std::nullopt;
  SweepDurationResult result;
  result.estimate = duration_estimator_.Estimate();
  const std::optional<double> found = DecideSweepDuration(result.estimate, duration_estimator_.MedianStep());
  result.is_found = found.has_value();
  result.seconds = found.value_or(duration_guess_->seconds);
  result.stamp_shift = (0.5 - duration_guess_->stamp_phase) * (result.seconds - duration_guess_->seconds);
  for (PosedScan& scan : scans_) scan.stamp += result.stamp_shift;
  ShiftStamps(result.stamp_shift, &keyframes_);
  return result;
}

Trajectory Slam::OptimizedTrajectory() const { return TrajectoryOf(graph_, scans_); }

Trajectory3 Slam::OptimizedTrajectory3() const { return Trajectory3Of(graph_, scans_); }

OccupancyGrid Slam::BuildMap(double cell_size) const {
  OccupancyGridOptions options = options_.grid;
  if (cell_size > 0.0) options.cell_size = cell_size;
  return MapOf(graph_, keyframes_, options);
}

}  // namespace arborslam
