#include "backend/loop/lost_scans.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "backend/graph/map_parts.h"
#include "frontend/matching/match_target.h"

namespace arborslam {
namespace {

// Scans in a row that are not found before the rest is given up.
constexpr int kMaxMisses = 5;
// The wide search grows by its own size with every scan that is not found, up to this many times.
constexpr int kMaxGrowth = 3;
// A scan that another map holds is taken from it if it fits the new one this much better.
constexpr double kBetter = 0.7;
// Keyframes of a map that is taken for a start that failed.
constexpr size_t kMaxBadStart = 10;

// A match in the near window and, when that is poor, in the wide one, as the tracker makes it.
MatchResult Search(const TrackerOptions& options, const Matcher& matcher, const MatchTarget& target,
                   const std::vector<Eigen::Vector2f>& points, const SE2& prediction, int growth) {
  const SearchPenalty penalty{options.translation_penalty, options.rotation_penalty};
  const MatchResult near =
      matcher.Match(target, points, prediction,
                    {options.near_translation, options.near_rotation, options.near_rotation_step, penalty});
  if (IsUsable(near.verdict) && near.score <= options.wide_score) return near;
  return matcher.MatchBetter(
      target, points, prediction,
      {growth * options.wide_translation, options.wide_rotation, options.wide_rotation_step, penalty},
      options.max_insert_score);
}

// How well scans fit the submaps to which they were matched.
class OldMaps {
 public:
  OldMaps(const Matcher& matcher, double cell_size, double max_distance, const std::vector<Submap>& submaps,
          const PoseGraph& graph)
      : matcher_(matcher), cell_size_(cell_size), max_distance_(max_distance), submaps_(submaps), graph_(graph) {}

  // [m], the least MHD of a keyframe with these points.
  double ScoreOf(KeyframeId id, const std::vector<Eigen::Vector2f>& points) {
    double least = max_distance_;
    for (const Constraint& constraint : graph_.constraints()) {
      if (!(constraint.to == NodeId(id)) || !IsMatch(constraint)) continue;
      const auto submap = std::find_if(submaps_.begin(), submaps_.end(),
                                       [&](const Submap& one) { return NodeId(one.id) == constraint.from; });
      if (submap == submaps_.end()) continue;
      auto target = targets_.find(submap->id);
      if (target == targets_.end()) {
        target = targets_.try_emplace(submap->id, *submap->cells.Get(), cell_size_, max_distance_).first;
      }
      least = std::min(least, matcher_.MatchNear(target->second, points, constraint.T_from_to).score);
    }
    return least;
  }

 private:
  const Matcher& matcher_;
  double cell_size_;     // [m]
  double max_distance_;  // [m]
  const std::vector<Submap>& submaps_;
  const PoseGraph& graph_;
  std::map<SubmapId, MatchTarget> targets_;
};

// The submap that begins at each keyframe that begins one.
std::map<KeyframeId, const Submap*> SubmapsByFirst(const std::vector<Submap>& submaps) {
  std::map<KeyframeId, const Submap*> by_first;
  for (const Submap& submap : submaps) {
    if (!submap.keyframes.empty()) by_first.emplace(submap.keyframes.front(), &submap);
  }
  return by_first;
}

}  // namespace

std::vector<KeyframeId> RecoverLostScans(const TrackerOptions& options, const Matcher& matcher, double cell_size,
                                         double max_distance, const std::vector<Keyframe>& keyframes,
                                         const std::vector<Submap>& submaps, PoseGraph* graph) {
  std::vector<Constraint> gaps;
  for (const Constraint& constraint : graph->constraints()) {
    if (constraint.kind == Constraint::Kind::kGap) gaps.push_back(constraint);
  }
  std::set<KeyframeId> recovered;
  const std::map<KeyframeId, const Submap*> submap_at = SubmapsByFirst(submaps);
  // The latest first: a short map between two gaps may belong to the one after it.
  for (auto gap = gaps.rbegin(); gap != gaps.rend(); ++gap) {
    const auto found = submap_at.find(KeyframeId{gap->to.value});
    if (found == submap_at.end()) continue;
    const Submap& submap = *found->second;
    const MapParts parts(*graph);
    std::map<size_t, size_t> num_measured;  // By part.
    std::set<NodeId> measured;
    for (const Constraint& constraint : graph->constraints()) {
      if (IsMatch(constraint) && measured.insert(constraint.to).second) ++num_measured[parts.Of(constraint.to)];
    }
    const MatchTarget target(*submap.cells.Get(), cell_size, max_distance);
    OldMaps old_maps(matcher, cell_size, max_distance, submaps, *graph);
    SE2 T_submap_next = graph->Pose(submap.id).Inverse() * graph->Pose(gap->to);
    int num_misses = 0;
    for (int i = gap->from.value; i >= 0 && num_misses < kMaxMisses; --i) {
      const KeyframeId id{i};
      const bool is_of_old_map = measured.count(id) > 0;
      if (parts.AreJoined(id, submap.id)) break;
      const bool is_bad_start = num_measured[parts.Of(id)] <= kMaxBadStart;
      const std::shared_ptr<const PlanarScan> scan = keyframes[static_cast<size_t>(i)].scan.Get();
      const MatchResult match =
          Search(options, matcher, target, scan->points, T_submap_next, std::min(1 + num_misses, kMaxGrowth));
      if (is_of_old_map && !is_bad_start && !(match.score < kBetter * old_maps.ScoreOf(id, scan->points))) break;
      if (!IsUsable(match.verdict) || match.score > options.max_insert_score) {
        ++num_misses;
        continue;
      }
      num_misses = 0;
      T_submap_next = match.pose;
      const std::vector<Constraint> removed = graph->Remove([id](const Constraint& constraint) {
        const bool is_anchor = IsMatch(constraint) && constraint.T_from_to.vector().isZero(0.0);
        return constraint.to == NodeId(id) && !is_anchor;
      });
      for (Constraint before : removed) {
        if (IsMatch(before)) continue;
        before.kind = Constraint::Kind::kGap;
        before.information = gap->information;
        graph->AddConstraint(before);
      }
      graph->SetPose(id, graph->Pose(submap.id) * match.pose);
      graph->AddConstraint({submap.id, id, match.pose, match.information, Constraint::Kind::kSubmap});
      recovered.insert(id);
    }
  }
  return {recovered.begin(), recovered.end()};
}

}  // namespace arborslam
