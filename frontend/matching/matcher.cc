#include "frontend/matching/matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace arborslam {
namespace {

// Poses nearer to the best one than this belong to the same mode.
constexpr double kModeTranslation = 0.5;  // [m]
constexpr double kModeRotation = 0.1;     // [rad]
// Of a point's distance to where the map has it: half a cell.
constexpr double kCellDeviation = 0.5;
// [standard deviations], a smaller difference between two means is none.
constexpr double kSigmas = 3.0;
// Around a refined pose, the best one on a search's grid is found in this.
constexpr SearchWindow kGridWindow{0.1, 0.02, 0.01, {}};

std::vector<Eigen::Vector2f> Subsample(const std::vector<Eigen::Vector2f>& points, int max_points) {
  const size_t stride = (points.size() + static_cast<size_t>(max_points) - 1) / static_cast<size_t>(max_points);
  if (stride <= 1) return points;
  std::vector<Eigen::Vector2f> sample;
  sample.reserve(points.size() / stride + 1);
  for (size_t i = 0; i < points.size(); i += stride) sample.push_back(points[i]);
  return sample;
}

}  // namespace

std::string MatcherOptions::Validate() const {
  std::ostringstream error;
  if (!(max_distance > 0.0 && max_distance <= 5.0)) {
    error << "max_distance is " << max_distance << " m, must lie in (0, 5]";
  } else if (max_search_points < 10) {
    error << "max_search_points is " << max_search_points << ", must be at least 10";
  } else if (!(max_score > 0.0 && max_score <= max_distance)) {
    error << "max_score is " << max_score << " m, must lie in (0, max_distance]";
  } else if (min_points < 3) {
    error << "min_points is " << min_points << ", must be at least 3";
  } else if (!(max_second_ratio > 0.0 && max_second_ratio <= 1.0)) {
    error << "max_second_ratio is " << max_second_ratio << ", must lie in (0, 1]";
  }
  return error.str();
}

const char* ToString(MatchVerdict verdict) {
  switch (verdict) {
    case MatchVerdict::kAccepted:
      return "accepted";
    case MatchVerdict::kTooFewPoints:
      return "too few points";
    case MatchVerdict::kPoor:
      return "poor";
    case MatchVerdict::kAmbiguous:
      return "ambiguous";
    case MatchVerdict::kDegenerate:
      return "degenerate";
  }
  return "unknown";
}

std::string RefusalReason(const MatchResult& match, double max_score, double min_overlap) {
  if (!IsUsable(match.verdict)) return ToString(match.verdict);
  if (match.score > max_score) return "score";
  if (match.inlier_ratio < min_overlap) return "overlap";
  return "";
}

Matcher::Matcher(const MatcherOptions& options, const MhdOptions& mhd, const RefinementOptions& refinement)
    : options_(options), mhd_(mhd), refinement_(refinement) {}

MatchResult Matcher::Match(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& prediction,
                           const SearchWindow& window, bool with_information) const {
  return MatchBetter(target, points, prediction, window, std::numeric_limits<double>::infinity(), with_information);
}

MatchResult Matcher::MatchBetter(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                                 const SE2& prediction, const SearchWindow& window, double max_cost,
                                 bool with_information) const {
  MatchResult result;
  result.pose = prediction;
  result.num_points = static_cast<int>(points.size());
  result.score = options_.max_distance;
  result.cost = options_.max_distance;
  if (result.num_points < options_.min_points || target.empty()) return result;

  const std::vector<Eigen::Vector2f> sample = Subsample(points, options_.max_search_points);
  const std::optional<SearchResult> found = BranchAndBound(target, sample, prediction, window, mhd_, max_cost);
  if (!found) {
    result.verdict = MatchVerdict::kPoor;
    return result;
  }
  result = RefineAndJudge(target, points, found->pose, prediction, with_information);
  result.cost = result.score + PenaltyOf(result.pose, prediction, window.penalty);
  result.num_scored = found->num_scored;
  return result;
}

void Matcher::CheckUniqueness(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                              const SearchWindow& window, MatchResult* match,
                              const std::optional<SeenOnly>& seen_only) const {
  // To compare modes takes a finer sample than to find one.
  const std::vector<Eigen::Vector2f> sample = Subsample(points, 2 * options_.max_search_points);
  const std::optional<SearchResult> best = BranchAndBound(
      target, sample, match->pose, kGridWindow, mhd_, std::numeric_limits<double>::infinity(), std::nullopt, seen_only);
  if (!best) return;
  // The search tells costs apart by quantisation steps: a perfect one, 0, must not rule out its equals.
  const double step = static_cast<double>(target.field().max_distance()) / MinPyramid::kNumSteps;
  double limit = std::max(best->cost, step) / options_.max_second_ratio;
  std::optional<SeenOnly> of_rivals = seen_only;
  if (of_rivals) {
    // Means over few points scatter: nor can two be told apart that differ by no more than that.
    const double deviation = kCellDeviation * target.field().cell_size();
    const double num_core = std::min(of_rivals->min_share, mhd_.alpha_min) * static_cast<double>(sample.size());
    limit = std::max(limit, best->cost + kSigmas * deviation / std::sqrt(best->num_used));
    // Leaves and grass fit about as well anywhere: what fits best, as what stands firm does, must do so, too.
    of_rivals->max_core_cost = std::max(best->core_cost / options_.max_second_ratio,
                                        best->core_cost + kSigmas * deviation / std::sqrt(num_core));
    // What fits more points than the match does is no worse a rival.
    of_rivals->max_near = best->num_used;
  }
  const std::optional<SearchResult> rival =
      BranchAndBound(target, sample, match->pose, window, mhd_, limit,
                     Exclusion{match->pose, kModeTranslation, kModeRotation, true}, of_rivals);
  if (!rival) return;
  match->verdict = MatchVerdict::kAmbiguous;
  match->second_score = rival->cost;
}

MatchResult Matcher::MatchNear(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                               const SE2& initial) const {
  MatchResult result;
  result.pose = initial;
  result.num_points = static_cast<int>(points.size());
  result.score = options_.max_distance;
  result.cost = options_.max_distance;
  if (result.num_points < options_.min_points || target.empty()) return result;
  return RefineAndJudge(target, points, initial, initial, true);
}

MatchResult Matcher::RefineAndJudge(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                                    const SE2& initial, const SE2& prediction, bool with_information) const {
  const RefinementResult refined = Refine(target, points, initial, prediction, mhd_, refinement_, with_information);
  MatchResult result;
  result.pose = refined.pose;
  result.information = refined.information;
  result.score = refined.mhd.score;
  result.cost = refined.mhd.score;
  result.inlier_ratio = refined.mhd.inlier_ratio;
  result.num_points = static_cast<int>(points.size());
  result.num_degenerate = refined.num_degenerate;
  result.verdict = result.score > options_.max_score ? MatchVerdict::kPoor
                   : refined.num_degenerate == 3     ? MatchVerdict::kTooFewPoints
                   : refined.num_degenerate > 0      ? MatchVerdict::kDegenerate
                                                     : MatchVerdict::kAccepted;
  return result;
}

}  // namespace arborslam
