#include "frontend/tracking/tracker.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "core/config/validation.h"
#include "core/geometry/angles.h"

namespace arborslam {
namespace {

// A younger submap is matched to from this many scans on: before, its map is one scan's noise.
constexpr size_t kMinKeyframesToMatch = 5;
// Keyframes put into a submap, by turning on the spot for instance, before its target is built anew all the same.
constexpr size_t kMaxTargetAge = 16;
// [m], by how much more than a scan's own reach a target covers, so that it serves the next scans too.
constexpr double kTargetMargin = 3.0;
// [standard deviations] of the prediction that the first search covers; at least these many [m] and [rad].
constexpr double kNearSigmas = 6.0;
constexpr double kMinNearTranslation = 0.15;
constexpr double kMinNearRotation = 0.06;
// Share of a scan's points that lie on the map, from which on it shows nothing new.
constexpr double kKnownShare = 0.8;
// [m], standard deviation of a prediction that places a degenerate scan: scans come so fast that others show the same.
constexpr double kSureTranslation = 0.2;
// Share of a scan's points that lie on the map, up to which it mostly shows what is new: no more than the MHD leaves
// out.
constexpr double kSeenShare = 0.7;
// Of the penalty for lying off the prediction, what is left when the robot's velocity is not known.
constexpr double kTieBreak = 0.1;
// Points that are said to be better, but score this much worse, are not.
constexpr double kMaxWorsening = 1.5;
// A wide search must do this much better than the near one to be believed.
constexpr double kWideGain = 0.8;
// [m], once lost, no other pose within this may fit nearly as well: more than from tree to tree and from row to row.
constexpr double kUniqueWithin = 5.0;
// The wide search grows by its own size with every scan that finds nothing, up to this many times.
constexpr int kMaxWideGrowth = 3;

}  // namespace

std::string TrackerOptions::Validate() const {
  if (!(near_translation > 0.0 && near_translation <= 20.0)) {
    return Violation("near_translation", near_translation, "lie in (0, 20] m");
  }
  if (!(near_rotation > 0.0 && near_rotation <= 3.15)) {
    return Violation("near_rotation", near_rotation, "lie in (0, 3.15] rad");
  }
  if (!(wide_translation >= near_translation && wide_translation <= 20.0)) {
    return Violation("wide_translation", wide_translation, "lie in [near_translation, 20] m");
  }
  if (!(wide_rotation >= near_rotation && wide_rotation <= 3.15)) {
    return Violation("wide_rotation", wide_rotation, "lie in [near_rotation, 3.15] rad");
  }
  if (!(near_rotation_step >= 0.0005 && near_rotation_step <= 0.2)) {
    return Violation("near_rotation_step", near_rotation_step, "lie in [0.0005, 0.2] rad");
  }
  if (!(wide_rotation_step >= 0.0005 && wide_rotation_step <= 0.2)) {
    return Violation("wide_rotation_step", wide_rotation_step, "lie in [0.0005, 0.2] rad");
  }
  if (!(translation_penalty >= 0.0)) {
    return Violation("translation_penalty", translation_penalty, "be at least 0");
  }
  if (!(rotation_penalty >= 0.0)) return Violation("rotation_penalty", rotation_penalty, "be at least 0 m per rad");
  if (!(wide_score > 0.0)) return Violation("wide_score", wide_score, "be above 0 m");
  if (!(max_insert_score > 0.0)) return Violation("max_insert_score", max_insert_score, "be above 0 m");
  if (!(submap_length > 0.0)) return Violation("submap_length", submap_length, "be above 0 m");
  if (!(rebuild_turn >= 0.0)) return Violation("rebuild_turn", rebuild_turn, "be at least 0 rad");
  if (!(rebuild_distance >= 0.0)) return Violation("rebuild_distance", rebuild_distance, "be at least 0 m");
  if (!(min_occupancy >= 0.5 && min_occupancy < 1.0)) {
    return Violation("min_occupancy", min_occupancy, "lie in [0.5, 1)");
  }
  if (!(keyframe_translation >= 0.0)) return Violation("keyframe_translation", keyframe_translation, "be at least 0 m");
  if (!(keyframe_rotation >= 0.0)) return Violation("keyframe_rotation", keyframe_rotation, "be at least 0 rad");
  if (!(keyframe_interval >= 0.0)) return Violation("keyframe_interval", keyframe_interval, "be at least 0 s");
  return "";
}

Tracker::Tracker(const TrackerOptions& options, const OccupancyGridOptions& grid, double max_distance,
                 const Matcher& matcher)
    : options_(options),
      grid_options_(grid),
      min_log_odds_(static_cast<float>(LogOddsOf(options.min_occupancy))),
      max_distance_(max_distance),
      matcher_(matcher) {}

TrackingResult Tracker::Track(const std::vector<Eigen::Vector2f>& points, const SE2& last_pose, const SE2& prediction,
                              bool knows_velocity, const Eigen::Vector3d& sigma, bool by_wheels,
                              const PointsAt& improve) {
  TrackingResult result;
  result.match.pose = prediction;
  result.match.num_points = static_cast<int>(points.size());
  if (active_.empty()) return result;
  float reach = 0.0f;
  for (const Eigen::Vector2f& point : points) reach = std::max(reach, point.squaredNorm());
  const int growth = std::min(1 + num_lost_, kMaxWideGrowth);
  const double wide_translation = growth * (by_wheels ? options_.near_translation : options_.wide_translation);
  const double wide_rotation =
      by_wheels ? std::min(growth * options_.near_rotation, options_.wide_rotation) : options_.wide_rotation;
  const double scan_reach = std::sqrt(reach) + wide_translation;

  ActiveSubmap& older = active_.front();
  const SE2 T_submap_prediction = older.T_odom_submap.Inverse() * prediction;
  const bool is_outdated = IsOutdated(older, T_submap_prediction, scan_reach, false);
  if (is_outdated) BuildTarget(T_submap_prediction, scan_reach, &older);
  const MatchTarget& target = *older.target;
  const SearchPenalty penalty{options_.translation_penalty, options_.rotation_penalty};
  const double translation = std::max(kMinNearTranslation, kNearSigmas * sigma.head<2>().maxCoeff());
  const double rotation = std::max(kMinNearRotation, kNearSigmas * sigma.z());
  SearchWindow near{std::min(options_.near_translation, translation), std::min(options_.near_rotation, rotation),
                    options_.near_rotation_step, penalty};
  if (!knows_velocity) {
    near.translation = wide_translation;
    near.penalty = {kTieBreak * penalty.per_metre, kTieBreak * penalty.per_radian};
  }
  // Where it is matched again, only that match's information counts.
  const bool is_last = !improve;
  MatchResult match = matcher_.Match(target, points, T_submap_prediction, near, is_last);
  if (match.verdict != MatchVerdict::kTooFewPoints && match.score > options_.wide_score) {
    // Once lost, the last pose says little, and only a clean match is believed.
    const bool is_lost = num_lost_ > 0;
    const SearchWindow wide{wide_translation, wide_rotation, options_.wide_rotation_step,
                            is_lost ? SearchPenalty{} : penalty};
    const SE2 wide_center = by_wheels ? T_submap_prediction : older.T_odom_submap.Inverse() * last_pose;
    const double max_cost = is_lost ? options_.max_insert_score : kWideGain * match.cost;
    MatchResult wide_match = matcher_.MatchBetter(target, points, wide_center, wide, max_cost, is_last);
    result.searched_wide = true;
    // A robot that was lost may be elsewhere, where a tree or a row farther on looks the same.
    if (is_lost && !by_wheels && IsUsable(wide_match.verdict)) {
      matcher_.CheckUniqueness(target, points, {kUniqueWithin, wide_rotation, options_.wide_rotation_step, {}},
                               &wide_match);
    }
    if (wide_match.cost < match.cost) match = wide_match;
  }
  const std::vector<Eigen::Vector2f>* best_points = &points;
  if (improve && IsUsable(match.verdict)) {
    const std::vector<Eigen::Vector2f>& improved = improve(older.T_odom_submap * match.pose);
    MatchResult again = matcher_.MatchNear(target, improved, match.pose);
    result.is_improved = IsUsable(again.verdict) && again.score <= kMaxWorsening * match.score;
    if (result.is_improved) {
      best_points = &improved;
    } else {
      again = matcher_.MatchNear(target, points, match.pose);
    }
    again.num_scored = match.num_scored;
    match = again;
  }
  const SE2 T_submap_base = match.pose;
  result.match = match;
  result.match.pose = IsUsable(match.verdict) ? older.T_odom_submap * T_submap_base : prediction;
  const bool is_new_ground =
      by_wheels && match.verdict != MatchVerdict::kTooFewPoints && match.inlier_ratio < kSeenShare;
  result.insert = is_new_ground || (IsUsable(match.verdict) && match.score <= options_.max_insert_score);
  num_lost_ = IsUsable(match.verdict) || is_new_ground ? 0 : num_lost_ + 1;
  if (!IsUsable(match.verdict)) return result;
  result.adds_nothing = match.verdict == MatchVerdict::kDegenerate && match.inlier_ratio >= kKnownShare &&
                        sigma.head<2>().maxCoeff() <= kSureTranslation;
  result.measurements.push_back({older.id, T_submap_base, match.information});
  for (size_t i = 1; i < active_.size(); ++i) {
    ActiveSubmap& younger = active_[i];
    if (younger.keyframes.size() < kMinKeyframesToMatch) continue;
    const SE2 initial = younger.T_odom_submap.Inverse() * result.match.pose;
    // No scan is to wait for two.
    if (IsOutdated(younger, initial, scan_reach, is_outdated)) BuildTarget(initial, scan_reach, &younger);
    const MatchResult second = matcher_.MatchNear(*younger.target, *best_points, initial);
    if (IsUsable(second.verdict)) result.measurements.push_back({younger.id, second.pose, second.information});
  }
  return result;
}

bool Tracker::IsOutdated(const ActiveSubmap& submap, const SE2& T_submap_base, double reach, bool may_wait) const {
  if (!submap.target) return true;
  if ((T_submap_base.translation() - submap.target_center).norm() + reach > submap.target_reach) return true;
  if (may_wait) return false;
  // A young submap changes with every scan; later ones matter less and less.
  const size_t age = submap.keyframes.size() - submap.target_keyframes;
  if (age > std::min(kMaxTargetAge, submap.target_keyframes / 4)) return true;
  return age > 0 && (submap.length - submap.target_length >= options_.rebuild_distance ||
                     submap.turn - submap.target_turn >= options_.rebuild_turn);
}

void Tracker::BuildTarget(const SE2& T_submap_base, double reach, ActiveSubmap* submap) const {
  submap->target_center = T_submap_base.translation();
  submap->target_reach = reach + kTargetMargin;
  submap->target_keyframes = submap->keyframes.size();
  submap->target_length = submap->length;
  submap->target_turn = submap->turn;
  MakeTarget(submap);
}

void Tracker::MakeTarget(ActiveSubmap* submap) const {
  std::vector<OccupiedCell> cells = submap->grid.OccupiedCells(min_log_odds_);
  const Eigen::Vector2f center = submap->target_center.cast<float>();
  const auto squared_reach = static_cast<float>(submap->target_reach * submap->target_reach);
  cells.erase(
      std::remove_if(cells.begin(), cells.end(),
                     [&](const OccupiedCell& cell) { return (cell.centroid - center).squaredNorm() > squared_reach; }),
      cells.end());
  submap->target = std::make_unique<MatchTarget>(cells, grid_options_.cell_size, max_distance_);
}

bool Tracker::IsKeyframe(const StampedPose& last_keyframe, const StampedPose& pose) const {
  const SE2 motion = last_keyframe.pose.Inverse() * pose.pose;
  return motion.translation().norm() >= options_.keyframe_translation ||
         std::abs(motion.theta()) >= options_.keyframe_rotation ||
         pose.stamp - last_keyframe.stamp >= options_.keyframe_interval;
}

std::optional<Submap> Tracker::Insert(KeyframeId id, const PlanarScan& scan, const SE2& T_odom_base,
                                      double max_length) {
  const double submap_length = std::min(options_.submap_length, max_length);
  if (active_.empty() || active_.back().length >= 0.5 * submap_length) {
    active_.emplace_back(SubmapId{num_submaps_++}, T_odom_base, grid_options_);
  }
  for (ActiveSubmap& submap : active_) {
    const SE2 T_submap_base = submap.T_odom_submap.Inverse() * T_odom_base;
    submap.grid.Insert(T_submap_base, scan);
    submap.keyframes.push_back(id);
    submap.inserted_at.push_back(T_submap_base);
    submap.length += (T_submap_base.translation() - submap.T_submap_last.translation()).norm();
    submap.turn += std::abs(AngleDifference(T_submap_base.theta(), submap.T_submap_last.theta()));
    submap.T_submap_last = T_submap_base;
  }
  if (active_.front().length < submap_length) return std::nullopt;
  const Submap finished = Finish(&active_.front());
  active_.pop_front();
  return finished;
}

bool Tracker::RestoreMaps(const std::function<std::shared_ptr<const PlanarScan>(KeyframeId)>& scan_of) {
  for (ActiveSubmap& submap : active_) {
    if (submap.keyframes.size() != submap.inserted_at.size()) return false;
    for (size_t i = 0; i < submap.keyframes.size(); ++i) {
      const std::shared_ptr<const PlanarScan> scan = scan_of(submap.keyframes[i]);
      if (scan == nullptr) return false;
      submap.grid.Insert(submap.inserted_at[i], *scan);
      if (i + 1 == submap.target_keyframes) MakeTarget(&submap);
    }
  }
  return true;
}

std::vector<SubmapId> Tracker::ActiveSubmaps() const {
  std::vector<SubmapId> ids;
  for (const ActiveSubmap& submap : active_) ids.push_back(submap.id);
  return ids;
}

const SE2& Tracker::SubmapPose(SubmapId id) const {
  const auto found =
      std::find_if(active_.begin(), active_.end(), [id](const ActiveSubmap& submap) { return submap.id == id; });
  CHECK(found != active_.end()) << "submap " << id.value << " is not active";
  return found->T_odom_submap;
}

void Tracker::SetSubmapPose(SubmapId id, const SE2& T_odom_submap) {
  for (ActiveSubmap& submap : active_) {
    if (submap.id == id) submap.T_odom_submap = T_odom_submap;
  }
}

std::vector<Submap> Tracker::FinishAll() {
  std::vector<Submap> finished;
  for (ActiveSubmap& submap : active_) finished.push_back(Finish(&submap));
  active_.clear();
  return finished;
}

Submap Tracker::Finish(ActiveSubmap* active) const {
  return {active->id, std::move(active->keyframes), active->grid.OccupiedCells(min_log_odds_)};
}

}  // namespace arborslam
