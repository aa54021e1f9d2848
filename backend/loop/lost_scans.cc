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
// Keyframes of a map that is taken for a start that failed.
constexpr size_t kMaxBadStart = 10;

// A match in the near window and, when that is poor, in the wide one, as the tracker makes it.
MatchResult Search(const TrackerOptions& options, const Matcher& matcher, const MatchTarget& target,
                   const std::vector<Eigen::Vector2f>& points, const SE2& prediction) {
  const SearchPenalty penalty{options.translation_penalty, options.rotation_penalty};
  const MatchResult near =
      matcher.Match(target, points, prediction,
                    {options.near_translation, options.near_rotation, options.near_rotation_step, penalty});
  if (IsUsable(near.verdict) && near.score <= options.wide_score) return near;
  return matcher.MatchBetter(target, points, prediction,
                             {options.wide_translation, options.wide_rotation, options.wide_rotation_step, penalty},
                             options.max_insert_score);
}

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
    SE2 T_submap_next = graph->Pose(submap.id).Inverse() * graph->Pose(gap->to);
    int num_misses = 0;
    for (int i = gap->from.value; i >= 0 && num_misses < kMaxMisses; --i) {
      const KeyframeId id{i};
      const bool is_of_old_map = measured.count(id) > 0;
      if (parts.AreJoined(id, submap.id)) break;
      if (is_of_old_map && num_measured[parts.Of(id)] > kMaxBadStart) break;
      const std::shared_ptr<const PlanarScan> scan = keyframes[static_cast<size_t>(i)].scan.Get();
      const MatchResult match = Search(options, matcher, target, scan->points, T_submap_next);
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
