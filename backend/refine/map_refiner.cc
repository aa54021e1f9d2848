#include "backend/refine/map_refiner.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <set>

#include "backend/graph/map_parts.h"
#include "core/config/validation.h"
#include "core/map/leave_one_out_map.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// Where a scan is looked for that may lie too far off to refine its place from there.
constexpr SearchWindow kLostWindow{1.0, 0.3, 0.01, {0.02, 0.0}};
// Matches that leave a standard deviation of more than this share of D_max in every direction hold hardly anything: the
// scan may lie in a wrong mode.
constexpr double kWeakShare = 1.0 / 3.0;

// What was measured of the keyframes in each submap, in the submaps' order.
using ConstraintsBySubmap = std::vector<std::vector<Constraint>>;

bool IsOf(const Submap& submap, KeyframeId id) {
  return std::binary_search(submap.keyframes.begin(), submap.keyframes.end(), id);
}

bool IsOfTheTimeOf(const Submap& submap, KeyframeId id) {
  return submap.keyframes.front() < id && id < submap.keyframes.back();
}

// [m], standard deviation of the position along the direction that is known best; infinite if none is.
double LeastDeviation(const Eigen::Matrix3d& information) {
  const Eigen::Matrix2d of_position = information.topLeftCorner<2, 2>();
  const double greatest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(of_position).eigenvalues().y();
  return greatest > 0.0 ? 1.0 / std::sqrt(greatest) : std::numeric_limits<double>::infinity();
}

// The keyframes that are held to `max_deviation` [m] or better in some direction.
std::set<NodeId> WellHeld(const ConstraintsBySubmap& foreign, const ConstraintsBySubmap& own, double max_deviation) {
  std::set<NodeId> held;
  for (const ConstraintsBySubmap* measured : {&foreign, &own}) {
    for (const auto& of_submap : *measured) {
      for (const Constraint& constraint : of_submap) {
        if (LeastDeviation(constraint.information) <= max_deviation) held.insert(constraint.to);
      }
    }
  }
  return held;
}

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

std::vector<OccupiedCell> MapRefiner::CellsOf(const Submap& submap, const PoseGraph& graph,
                                              const std::vector<Keyframe>& keyframes) const {
  const SE2 T_submap_map = graph.Pose(submap.id).Inverse();
  OccupancyGrid grid(grid_options_);
  for (const KeyframeId id : submap.keyframes) {
    grid.Insert(T_submap_map * graph.Pose(id), *keyframes[static_cast<size_t>(id.value)].scan.Get());
  }
  return grid.OccupiedCells(min_log_odds_);
}

LeaveOneOutMap MapRefiner::LeaveOneOutMapOf(const Submap& submap, const PoseGraph& graph,
                                            const std::vector<Keyframe>& keyframes) const {
  const SE2 T_submap_map = graph.Pose(submap.id).Inverse();
  std::vector<SE2> poses;
  std::vector<std::shared_ptr<const PlanarScan>> scans;
  for (const KeyframeId id : submap.keyframes) {
    poses.push_back(T_submap_map * graph.Pose(id));
    scans.push_back(keyframes[static_cast<size_t>(id.value)].scan.Get());
  }
  return {grid_options_, poses, scans};
}

PoseGraph MapRefiner::Remeasure(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                std::vector<Submap>* submaps, int num_threads) const {
  const auto measure = [&](const MatchTarget& target, const Submap& submap, const Keyframe& keyframe,
                           bool is_lost) -> std::optional<Constraint> {
    const SE2 initial = graph.Pose(submap.id).Inverse() * graph.Pose(keyframe.id);
    const std::shared_ptr<const PlanarScan> scan = keyframe.scan.Get();
    const MatchResult match = is_lost ? matcher_.Match(target, scan->points, initial, kLostWindow)
                                      : matcher_.MatchNear(target, scan->points, initial);
    if (!IsUsable(match.verdict)) return std::nullopt;
    const Constraint::Kind kind = IsOf(submap, keyframe.id) ? Constraint::Kind::kSubmap : Constraint::Kind::kLoop;
    return Constraint{submap.id, keyframe.id, match.pose, match.information, kind};
  };
  const MapParts parts(graph);
  ConstraintsBySubmap foreign(submaps->size());
  ParallelFor(submaps->size(), num_threads, [&](size_t i) {
    Submap& submap = (*submaps)[i];
    submap.cells = submap.cells.Replaced(CellsOf(submap, graph, keyframes));
    const MatchTarget target(*submap.cells.Get(), grid_options_.cell_size, max_distance_);
    for (const Keyframe& keyframe : keyframes) {
      if (IsOf(submap, keyframe.id) || !parts.AreJoined(submap.id, keyframe.id)) continue;
      const Eigen::Vector2d& position = graph.Pose(keyframe.id).translation();
      const bool near = std::any_of(submap.keyframes.begin(), submap.keyframes.end(), [&](KeyframeId member) {
        return (graph.Pose(member).translation() - position).norm() <= options_.radius;
      });
      if (!near) continue;
      // A spoilt scan may lie where only the motion model put it: its place is searched for in the maps of its time.
      const bool is_lost = !keyframe.is_inserted && IsOfTheTimeOf(submap, keyframe.id);
      const std::optional<Constraint> measured = measure(target, submap, keyframe, is_lost);
      if (measured) foreign[i].push_back(*measured);
    }
  });
  std::set<NodeId> seen_by_others;
  for (const auto& of_submap : foreign) {
    for (const Constraint& constraint : of_submap) seen_by_others.insert(constraint.to);
  }
  // A scan that is part of a map matches it where it already lies, which would hold every pose where it is. So a
  // submap's own keyframes count only where no other submap has seen them.
  ConstraintsBySubmap own(submaps->size());
  ParallelFor(submaps->size(), num_threads, [&](size_t i) {
    const Submap& submap = (*submaps)[i];
    std::optional<MatchTarget> target;
    for (const KeyframeId id : submap.keyframes) {
      if (seen_by_others.count(id) > 0) continue;
      if (!target) target.emplace(*submap.cells.Get(), grid_options_.cell_size, max_distance_);
      const std::optional<Constraint> measured =
          measure(*target, submap, keyframes[static_cast<size_t>(id.value)], false);
      if (measured) own[i].push_back(*measured);
    }
  });
  // Nor does such a map show that a scan which holds hardly anything lies wrong. It is searched for in the maps of its
  // time as they are without it.
  const std::set<NodeId> well_held = WellHeld(foreign, own, kWeakShare * max_distance_);
  ParallelFor(submaps->size(), num_threads, [&](size_t i) {
    const Submap& submap = (*submaps)[i];
    std::optional<LeaveOneOutMap> map;
    for (size_t k = 0; k < submap.keyframes.size(); ++k) {
      const KeyframeId id = submap.keyframes[k];
      if (well_held.count(id) > 0 || !IsOfTheTimeOf(submap, id)) continue;
      if (!map) map.emplace(LeaveOneOutMapOf(submap, graph, keyframes));
      const MatchTarget target(map->OccupiedCellsWithout(k, min_log_odds_), grid_options_.cell_size, max_distance_);
      const std::optional<Constraint> measured =
          measure(target, submap, keyframes[static_cast<size_t>(id.value)], true);
      if (!measured) continue;
      std::vector<Constraint>& known = own[i];
      known.erase(
          std::remove_if(known.begin(), known.end(), [id](const Constraint& one) { return one.to == NodeId(id); }),
          known.end());
      known.push_back(*measured);
    }
  });

  PoseGraph refined;
  for (const auto& [id, pose] : graph.poses()) refined.AddNode(id, pose);
  for (const Constraint& constraint : graph.constraints()) {
    if (!IsMatch(constraint)) refined.AddConstraint(constraint);
  }
  for (const auto* measured : {&foreign, &own}) {
    for (const auto& of_submap : *measured) {
      for (const Constraint& constraint : of_submap) refined.AddConstraint(constraint);
    }
  }
  return refined;
}

}  // namespace arborslam
