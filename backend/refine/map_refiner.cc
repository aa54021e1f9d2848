#include "backend/refine/map_refiner.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "core/config/validation.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// Where a spoilt scan is looked for.
constexpr SearchWindow kSpoiltWindow{1.0, 0.3, 0.01, {0.02, 0.0}};

}  // namespace

std::string MapRefinementOptions::Validate() const {
  if (num_passes < 0 || num_passes > 100) return Violation("num_passes", num_passes, "lie in [0, 100]");
  if (!(radius >= 0.0)) return Violation("radius", radius, "be at least 0 m");
  return "";
}

MapRefiner::MapRefiner(const MapRefinementOptions& options, const OccupancyGridOptions& grid, double min_occupancy,
                       double max_distance, const Matcher& matcher)
    : options_(options),
      grid_options_(grid),
      min_log_odds_(static_cast<float>(LogOddsOf(min_occupancy))),
      max_distance_(max_distance),
      matcher_(matcher) {}

PoseGraph MapRefiner::Remeasure(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                std::vector<Submap>* submaps, int num_threads) const {
  const auto measure = [&](const MatchTarget& target, const Submap& submap, const Keyframe& keyframe,
                           Constraint::Kind kind) -> std::optional<Constraint> {
    // A spoilt scan may lie where only the motion model put it, too far off to refine from there: its place is
    // searched for in the maps of its own time.
    const bool is_of_this_time = submap.keyframes.front() < keyframe.id && keyframe.id < submap.keyframes.back();
    const SE2 initial = graph.Pose(submap.id).Inverse() * graph.Pose(keyframe.id);
    const std::shared_ptr<const PlanarScan> scan = keyframe.scan.Get();
    const MatchResult match = !keyframe.is_inserted && is_of_this_time
                                  ? matcher_.Match(target, scan->points, initial, kSpoiltWindow)
                                  : matcher_.MatchNear(target, scan->points, initial);
    if (!IsUsable(match.verdict)) return std::nullopt;
    return Constraint{submap.id, keyframe.id, match.pose, match.information, kind};
  };
  const auto is_own = [](const Submap& submap, KeyframeId id) {
    return std::binary_search(submap.keyframes.begin(), submap.keyframes.end(), id);
  };
  std::vector<std::vector<Constraint>> foreign(submaps->size());
  ParallelFor(submaps->size(), num_threads, [&](size_t i) {
    Submap& submap = (*submaps)[i];
    const SE2 T_submap_map = graph.Pose(submap.id).Inverse();
    OccupancyGrid grid(grid_options_);
    for (const KeyframeId id : submap.keyframes) {
      grid.Insert(T_submap_map * graph.Pose(id), *keyframes[static_cast<size_t>(id.value)].scan.Get());
    }
    submap.cells = submap.cells.Replaced(grid.OccupiedCells(min_log_odds_));
    const MatchTarget target(*submap.cells.Get(), grid_options_.cell_size, max_distance_);
    for (const Keyframe& keyframe : keyframes) {
      if (is_own(submap, keyframe.id)) continue;
      const Eigen::Vector2d& position = graph.Pose(keyframe.id).translation();
      const bool near = std::any_of(submap.keyframes.begin(), submap.keyframes.end(), [&](KeyframeId member) {
        return (graph.Pose(member).translation() - position).norm() <= options_.radius;
      });
      if (!near) continue;
      const std::optional<Constraint> measured = measure(target, submap, keyframe, Constraint::Kind::kLoop);
      if (measured) foreign[i].push_back(*measured);
    }
  });
  std::set<NodeId> seen_by_others;
  for (const auto& of_submap : foreign) {
    for (const Constraint& constraint : of_submap) seen_by_others.insert(constraint.to);
  }
  // A scan that is part of a map matches it where it already lies, which would hold every pose where it is. So a
  // submap's own keyframes count only where no other submap has seen them.
  std::vector<std::vector<Constraint>> own(submaps->size());
  ParallelFor(submaps->size(), num_threads, [&](size_t i) {
    const Submap& submap = (*submaps)[i];
    std::optional<MatchTarget> target;
    for (const KeyframeId id : submap.keyframes) {
      if (seen_by_others.count(id) > 0) continue;
      if (!target) target.emplace(*submap.cells.Get(), grid_options_.cell_size, max_distance_);
      const std::optional<Constraint> measured =
          measure(*target, submap, keyframes[static_cast<size_t>(id.value)], Constraint::Kind::kSubmap);
      if (measured) own[i].push_back(*measured);
    }
  });

  PoseGraph refined;
  for (const auto& [id, pose] : graph.poses()) refined.AddNode(id, pose);
  for (const Constraint& constraint : graph.constraints()) {
    if (constraint.kind == Constraint::Kind::kMotion) refined.AddConstraint(constraint);
  }
  for (const auto* measured : {&foreign, &own}) {
    for (const auto& of_submap : *measured) {
      for (const Constraint& constraint : of_submap) refined.AddConstraint(constraint);
    }
  }
  return refined;
}

}  // namespace arborslam
