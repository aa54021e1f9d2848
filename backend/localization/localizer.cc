#include "backend/localization/localizer.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/config/validation.h"

namespace arborslam {
namespace {

constexpr int kMaxBlindScans = 2;  // In a row that match neither the map nor the scans before.

// Submaps that a scan is matched to at most, and targets that are kept in memory.
constexpr size_t kMaxSubmaps = 3;
constexpr size_t kNumTargets = 16;
// [m], a submap whose keyframes are all farther from the robot than this shows it nothing.
constexpr double kMaxSubmapDistance = 10.0;
// Scans in a row that the odometry may reject before it is begun anew.
constexpr int kMaxOdometryMisses = 3;

// Every scan is looked for in the map, also when the odometry takes the robot to stand, which may be wrong.
SlamOptions EveryScanAKeyframe(SlamOptions options) {
  options.tracker.keyframe_translation = 0.0;
  options.tracker.keyframe_rotation = 0.0;
  return options;
}

}  // namespace

std::string LocalizerOptions::Validate() const {
  if (!(search_translation > 0.0 && search_translation <= 20.0)) {
    return Violation("search_translation", search_translation, "lie in (0, 20] m");
  }
  if (!(search_rotation > 0.0 && search_rotation <= 3.15)) {
    return Violation("search_rotation", search_rotation, "lie in (0, 3.15] rad");
  }
  if (!(max_score > 0.0)) return Violation("max_score", max_score, "be above 0 m");
  if (!(min_overlap >= 0.0 && min_overlap <= 1.0)) return Violation("min_overlap", min_overlap, "lie in [0, 1]");
  if (max_misses < 1) return Violation("max_misses", max_misses, "be at least 1");
  if (min_votes < 1) return Violation("min_votes", min_votes, "be at least 1");
  if (vote_keyframes < min_votes) return Violation("vote_keyframes", vote_keyframes, "be at least min_votes");
  if (!(vote_translation > 0.0)) return Violation("vote_translation", vote_translation, "be above 0 m");
  if (!(vote_rotation > 0.0)) return Violation("vote_rotation", vote_rotation, "be above 0 rad");
  if (!(jump_translation > 0.0)) return Violation("jump_translation", jump_translation, "be above 0 m");
  return "";
}

const char* ToString(LocalizationState state) {
  switch (state) {
    case LocalizationState::kNotYetLocated:
      return "not yet located";
    case LocalizationState::kLocated:
      return "located";
    case LocalizationState::kLost:
      return "lost";
  }
  return "unknown";
}

Localizer::Localizer(const SlamOptions& options, const LocalizerOptions& localizer, const PoseGraph& graph,
                     const std::vector<Keyframe>& keyframes, const std::vector<Submap>& submaps,
                     const std::optional<SE2>& initial_pose, std::shared_ptr<ValueStore> store)
    : slam_options_(EveryScanAKeyframe(options)),
      options_(localizer),
      graph_(graph),
      keyframes_(keyframes),
      submaps_(submaps),
      matcher_(options.matcher, options.mhd, options.refinement),
      recognizer_(options.place, matcher_, options.matcher.max_second_ratio, graph, keyframes, submaps),
      targets_(submaps, options.grid.cell_size, options.matcher.max_distance, kNumTargets),
      store_(std::move(store)),
      odometry_(std::make_unique<Slam>(slam_options_, 1, store_)),
      vote_translation_step_(options.tracker.keyframe_translation),
      vote_rotation_step_(options.tracker.keyframe_rotation),
      initial_pose_(initial_pose) {
  for (const Submap& submap : submaps) paths_.emplace_back(submap, graph);
}

template <class AnyScan>
LocalizationResult Localizer::Add(const AnyScan& scan) {
  LocalizationResult result;
  result.odometry = odometry_->AddScan(scan);
  if (result.odometry.status == ScanStatus::kSkipped) {
    result.state = state_;
    result.reason = result.odometry.reason;
    return result;
  }
  num_odometry_misses_ = result.odometry.status == ScanStatus::kMatched ? 0 : num_odometry_misses_ + 1;
  result.T_map_base = T_map_odom_ * result.odometry.T_odom_base;
  const std::shared_ptr<const PlanarScan> planar = odometry_->keyframes().back().scan.Get();
  const std::vector<Eigen::Vector2f>& points = planar->points;
  if (initial_pose_) {
    const MatchResult match =
        MatchInMap(points, *initial_pose_, slam_options_.place.search_translation, slam_options_.place.search_rotation);
    initial_pose_.reset();
    if (IsFound(match)) {
      T_map_odom_ = match.pose * result.odometry.T_odom_base.Inverse();
      state_ = LocalizationState::kLocated;
      result.is_fix = true;
      result.T_map_base = match.pose;
    }
  }
  if (state_ == LocalizationState::kLocated) {
    TrackInMap(points, &result);
  } else if (HasMovedSinceAsked(result.odometry.T_odom_base)) {
    asked_at_ = result.odometry.T_odom_base;
    SearchInMap(points, &result);
  } else {
    result.reason = "not moved";
  }
  result.state = state_;
  if (num_odometry_misses_ > kMaxOdometryMisses) {
    RestartOdometry();
    num_misses_ = std::max(num_misses_, 1);
  }
  return result;
}

void Localizer::TrackInMap(const std::vector<Eigen::Vector2f>& points, LocalizationResult* result) {
  // What was missed may have been a bad step of the odometry: then the robot is looked for a little farther around.
  const bool is_sure = num_misses_ == 0 && num_odometry_misses_ == 0;
  const SE2 prediction = result->T_map_base;
  result->match =
      MatchInMap(points, prediction, is_sure ? options_.search_translation : slam_options_.place.search_translation,
                 is_sure ? options_.search_rotation : slam_options_.place.search_rotation);
  result->reason = RefusalReason(result->match, options_.max_score, options_.min_overlap);
  if (result->reason.empty()) {
    result->is_measured = true;
    result->T_map_base = result->match.pose;
    const double step = (result->match.pose.translation() - prediction.translation()).norm();
    if (step > options_.jump_translation) result->jump = step;
    T_map_odom_ = result->match.pose * result->odometry.T_odom_base.Inverse();
    num_misses_ = 0;
    return;
  }
  // Found neither in the map nor beside its last scans, the robot is elsewhere.
  if (++num_misses_ < options_.max_misses && num_odometry_misses_ < kMaxBlindScans) return;
  state_ = LocalizationState::kLost;
  num_misses_ = 0;
  RestartOdometry();
}

bool Localizer::HasMovedSinceAsked(const SE2& T_odom_base) const {
  if (!asked_at_) return true;
  const SE2 motion = asked_at_->Inverse() * T_odom_base;
  return motion.translation().norm() >= vote_translation_step_ || std::abs(motion.theta()) >= vote_rotation_step_;
}

void Localizer::SearchInMap(const std::vector<Eigen::Vector2f>& points, LocalizationResult* result) {
  const PlaceRecognition recognition = recognizer_.Recognize(points, &targets_);
  const SE2& T_odom_base = result->odometry.T_odom_base;
  std::optional<SE2> vote;
  if (recognition.best) {
    const PlaceCandidate& place = recognition.candidates[*recognition.best];
    result->match = place.match;
    vote = place.T_map_base * T_odom_base.Inverse();
  } else {
    result->reason = recognition.reason;
  }
  votes_.push_back(vote);
  if (votes_.size() > static_cast<size_t>(options_.vote_keyframes)) votes_.pop_front();
  if (!vote) return;
  int num_agreeing = 0;
  int num_other = 0;
  for (const std::optional<SE2>& other : votes_) {
    if (!other) continue;
    // Where both place the robot now.
    const bool agrees =
        AreClose(*other * T_odom_base, *vote * T_odom_base, options_.vote_translation, options_.vote_rotation);
    ++(agrees ? num_agreeing : num_other);
  }
  if (num_agreeing < options_.min_votes || num_agreeing <= 2 * num_other) {
    result->reason = "not yet confirmed";
    return;
  }
  // A robot that was lost goes on elsewhere: by how much is told.
  if (state_ == LocalizationState::kLost) {
    result->jump = (*vote * T_odom_base.translation() - result->T_map_base.translation()).norm();
    if (result->jump <= options_.jump_translation) result->jump = 0.0;
  }
  T_map_odom_ = *vote;
  state_ = LocalizationState::kLocated;
  votes_.clear();
  num_misses_ = 0;
  result->T_map_base = T_map_odom_ * T_odom_base;
  result->is_fix = true;
  result->is_measured = true;
}

MatchResult Localizer::MatchInMap(const std::vector<Eigen::Vector2f>& points, const SE2& T_map_base, double translation,
                                  double rotation) {
  MatchResult best;
  best.pose = T_map_base;
  for (const size_t index : SubmapsAround(T_map_base)) {
    const SE2& T_map_submap = graph_.Pose(submaps_[index].id);
    const SearchPenalty penalty{slam_options_.tracker.translation_penalty, slam_options_.tracker.rotation_penalty};
    MatchResult match = matcher_.Match(targets_.Get(index), points, T_map_submap.Inverse() * T_map_base,
                                       SearchWindow{translation, rotation, 0.01, penalty});
    match.pose = T_map_submap * match.pose;
    if (!IsUsable(best.verdict) || (IsUsable(match.verdict) && match.score < best.score)) best = match;
    if (IsFound(best)) break;
  }
  return best;
}

std::vector<size_t> Localizer::SubmapsAround(const SE2& T_map_base) const {
  std::vector<std::pair<double, size_t>> distances;
  for (size_t i = 0; i < submaps_.size(); ++i) {
    const double distance = paths_[i].DistanceTo(T_map_base.translation(), kMaxSubmapDistance);
    if (distance <= kMaxSubmapDistance) distances.emplace_back(distance, i);
  }
  std::sort(distances.begin(), distances.end());
  std::vector<size_t> around;
  for (size_t i = 0; i < std::min(distances.size(), kMaxSubmaps); ++i) around.push_back(distances[i].second);
  return around;
}

bool Localizer::IsFound(const MatchResult& match) const {
  return RefusalReason(match, options_.max_score, options_.min_overlap).empty();
}

void Localizer::RestartOdometry() {
  T_map_odom_ = T_map_odom_ * odometry_->OptimizedTrajectory().back().pose;
  odometry_ = std::make_unique<Slam>(slam_options_, 1, store_);
  votes_.clear();
  asked_at_.reset();
  num_odometry_misses_ = 0;
}

template LocalizationResult Localizer::Add(const LaserScan&);
template LocalizationResult Localizer::Add(const LidarSweep&);

}  // namespace arborslam
