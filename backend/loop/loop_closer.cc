#include "backend/loop/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "backend/graph/map_parts.h"
#include "backend/loop/relative_uncertainty.h"
#include "backend/loop/submap_path.h"
#include "backend/loop/tracked_share.h"
#include "core/config/validation.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// A keyframe to be tried against a submap.
struct Pair {
  KeyframeId keyframe;
  double distance;            // [m] from the submap's path.
  double search_translation;  // [m]
  double search_rotation;     // [rad]
};

// A window reaches so much farther at its corners than at its sides; matching refines poses there a little.
constexpr double kCorner = 1.5;
// Less than this share of the scans around put into maps: the run was lost there.
constexpr double kTrackedShare = 0.5;
// Keyframes before and after, of which a keyframe's share is taken.
constexpr size_t kTrackedReach = 10;
// Cells of what is known to be free of a submap are so much greater than its own,
constexpr double kFreeCoarseness = 2.0;
// and every so many of its scans tell of it.
constexpr size_t kFreeStride = 3;

// The window for a keyframe that is known with `covariance`; without one, the widest.
Pair WithWindow(Pair pair, const std::optional<Eigen::Matrix3d>& covariance, const LoopOptions& options) {
  pair.search_translation = options.max_search_translation;
  pair.search_rotation = options.max_search_rotation;
  if (!covariance) return pair;
  const SearchedWindow window = WindowOf(*covariance);
  pair.search_translation = std::clamp(window.translation, options.search_translation, options.max_search_translation);
  pair.search_rotation = std::clamp(window.rotation, options.search_rotation, options.max_search_rotation);
  return pair;
}

// The keyframes that may see a submap of which the graph knows nothing yet, in their order. What was made while lost
// sees nothing, and is not seen.
std::vector<Pair> PairsOf(const Submap& submap, const std::vector<Keyframe>& keyframes, const TrackedShare& tracked,
                          const PoseGraph& graph, const MapParts& parts, const RelativeUncertainty::View& uncertainty,
                          const std::set<LoopPair>& known, const LoopOptions& options) {
  if (tracked.Of(submap) < kTrackedShare) return {};
  // What is not known well may be nearer than it seems.
  const double reach = options.candidate_radius + options.max_search_translation - options.search_translation;
  const std::set<KeyframeId> members(submap.keyframes.begin(), submap.keyframes.end());
  const SubmapPath path(submap, graph);
  std::vector<Pair> pairs;
  for (size_t i = 0; i < keyframes.size(); i += static_cast<size_t>(options.keyframe_stride)) {
    const KeyframeId id = keyframes[i].id;
    if (!keyframes[i].is_inserted || tracked.Around(i, kTrackedReach) < kTrackedShare) continue;
    if (members.count(id) > 0 || known.count({submap.id, id}) > 0 || !parts.AreJoined(submap.id, id)) continue;
    const double distance = path.DistanceTo(graph.Pose(id).translation(), reach);
    if (!(distance < reach)) continue;
    const Pair pair = WithWindow({id, distance, 0.0, 0.0}, uncertainty.Of(id), options);
    if (pair.distance <= options.candidate_radius + pair.search_translation - options.search_translation) {
      pairs.push_back(pair);
    }
  }
  return pairs;
}

// True if the search of the window around `prediction` cannot end otherwise than `tried` did.
bool IsSettled(const LoopCandidate& tried, const SE2& prediction, const Pair& pair) {
  if (tried.accepted) return true;
  const bool was_searched =
      AreClose(tried.prediction, prediction, 0.5 * tried.search_translation, 0.5 * tried.search_rotation);
  if (!was_searched) return false;
  // A better place far off may have hidden the one that is looked for now.
  return !IsUsable(tried.match.verdict) ||
         AreClose(tried.match.pose, prediction, kCorner * pair.search_translation, kCorner * pair.search_rotation);
}

// Where the submap, whose scans lie in it as in the graph `tracked`, is known to hold nothing.
FreeArea FreeAreaOf(const Submap& submap, const std::vector<Keyframe>& keyframes, const PoseGraph& tracked,
                    OccupancyGridOptions options) {
  options.cell_size *= kFreeCoarseness;
  options.miss_range *= kFreeCoarseness;
  OccupancyGrid grid(options);
  const SE2 T_submap_map = tracked.Pose(submap.id).Inverse();
  for (size_t i = 0; i < submap.keyframes.size(); i += kFreeStride) {
    const Keyframe& keyframe = keyframes[static_cast<size_t>(submap.keyframes[i].value)];
    grid.Insert(T_submap_map * tracked.Pose(keyframe.id), *keyframe.scan.Get());
  }
  return FreeArea(grid);
}

// Of each keyframe's pairs, by submap, keeps those with the `count` nearest submaps.
void KeepNearest(int count, std::vector<std::vector<Pair>>* of_submaps) {
  std::map<int, std::vector<std::pair<double, size_t>>> distances;  // And submaps, by keyframe.
  for (size_t i = 0; i < of_submaps->size(); ++i) {
    for (const Pair& pair : (*of_submaps)[i]) distances[pair.keyframe.value].emplace_back(pair.distance, i);
  }
  std::vector<std::set<int>> kept(of_submaps->size());
  for (auto& [keyframe, submaps] : distances) {
    std::sort(submaps.begin(), submaps.end());
    submaps.resize(std::min(submaps.size(), static_cast<size_t>(count)));
    for (const auto& [distance, submap] : submaps) kept[submap].insert(keyframe);
  }
  for (size_t i = 0; i < of_submaps->size(); ++i) {
    std::vector<Pair>& pairs = (*of_submaps)[i];
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const Pair& pair) { return kept[i].count(pair.keyframe.value) == 0; }),
                pairs.end());
  }
}

}  // namespace

std::string LoopOptions::Validate() const {
  if (!(candidate_radius >= 0.0)) return Violation("candidate_radius", candidate_radius, "be at least 0 m");
  if (keyframe_stride < 1) return Violation("keyframe_stride", keyframe_stride, "be at least 1");
  if (!(search_translation > 0.0 && search_translation <= 50.0)) {
    return Violation("search_translation", search_translation, "lie in (0, 50] m");
  }
  if (!(search_rotation > 0.0 && search_rotation <= 3.15)) {
    return Violation("search_rotation", search_rotation, "lie in (0, 3.15] rad");
  }
  if (max_submaps < 1) return Violation("max_submaps", max_submaps, "be at least 1");
  if (!(max_search_translation >= search_translation && max_search_translation <= 50.0)) {
    return Violation("max_search_translation", max_search_translation, "lie in [search_translation, 50] m");
  }
  if (!(max_search_rotation >= search_rotation && max_search_rotation <= 3.15)) {
    return Violation("max_search_rotation", max_search_rotation, "lie in [search_rotation, 3.15] rad");
  }
  if (!(rival_translation > 0.0 && rival_translation <= 50.0)) {
    return Violation("rival_translation", rival_translation, "lie in (0, 50] m");
  }
  if (!(rival_share > 0.0 && rival_share <= 1.0)) return Violation("rival_share", rival_share, "lie in (0, 1]");
  if (drift_votes < 0) return Violation("drift_votes", drift_votes, "be at least 0");
  if (!(max_score > 0.0)) return Violation("max_score", max_score, "be above 0 m");
  if (!(min_overlap >= 0.0 && min_overlap <= 1.0)) return Violation("min_overlap", min_overlap, "lie in [0, 1]");
  return "";
}

LoopCloser::LoopCloser(const LoopOptions& options, const MatcherOptions& matcher_options, const Matcher& matcher,
                       const OccupancyGridOptions& grid)
    : options_(options), max_distance_(matcher_options.max_distance), matcher_(matcher), grid_(grid) {}

std::vector<LoopCandidate> LoopCloser::FindAll(const PoseGraph& graph, const PoseGraph& tracked,
                                               const std::vector<Keyframe>& keyframes,
                                               const std::vector<Submap>& submaps, const LoopsByPair& tried,
                                               int num_threads) const {
  const RelativeUncertainty uncertainty(graph);
  const TrackedShare share(keyframes);
  const MapParts parts(graph);
  std::set<LoopPair> known;
  for (const Constraint& constraint : graph.constraints()) {
    if (constraint.from.kind != NodeId::Kind::kSubmap) continue;
    const LoopPair pair(SubmapId{constraint.from.value}, KeyframeId{constraint.to.value});
    if (tried.count(pair) == 0) known.insert(pair);
  }
  std::vector<std::vector<Pair>> near(submaps.size());
  ParallelFor(submaps.size(), num_threads, [&](size_t i) {
    near[i] = PairsOf(submaps[i], keyframes, share, graph, parts, uncertainty.From(submaps[i].id), known, options_);
  });
  KeepNearest(options_.max_submaps, &near);

  std::vector<std::vector<LoopCandidate>> found(submaps.size());
  ParallelFor(submaps.size(), num_threads, [&](size_t i) {
    std::optional<MatchTarget> target;
    std::optional<MinPyramid> seen;
    const auto get_seen = [&] {
      if (!seen) seen.emplace(target->field(), FreeAreaOf(submaps[i], keyframes, tracked, grid_), 1);
      return &*seen;
    };
    for (const Pair& pair : near[i]) {
      const SE2 prediction = graph.Pose(submaps[i].id).Inverse() * graph.Pose(pair.keyframe);
      const auto earlier = tried.find({submaps[i].id, pair.keyframe});
      if (earlier != tried.end() && IsSettled(earlier->second, prediction, pair)) continue;
      if (!target) target.emplace(*submaps[i].cells.Get(), grid_.cell_size, max_distance_);
      const Keyframe& keyframe = keyframes[static_cast<size_t>(pair.keyframe.value)];
      LoopCandidate candidate{keyframe.id, submaps[i].id, prediction, pair.search_translation, pair.search_rotation,
                              {},          false,         ""};
      Judge(*target, get_seen, keyframe.scan.Get()->points, &candidate);
      found[i].push_back(candidate);
    }
  });
  std::vector<LoopCandidate> candidates;
  for (const auto& of_submap : found) candidates.insert(candidates.end(), of_submap.begin(), of_submap.end());
  return candidates;
}

void LoopCloser::Judge(const MatchTarget& target, const std::function<MinPyramid*()>& seen,
                       const std::vector<Eigen::Vector2f>& points, LoopCandidate* candidate) const {
  const double rotation = candidate->search_rotation;
  const SearchWindow window{candidate->search_translation, rotation, 0.01, {}};
  candidate->match = matcher_.Match(target, points, candidate->prediction, window);
  candidate->reason = RefusalReason(candidate->match, options_.max_score, options_.min_overlap);
  if (candidate->reason.empty()) {
    matcher_.CheckUniqueness(target, points, SearchWindow{options_.rival_translation, rotation, 0.02, {}},
                             &candidate->match, SeenOnly{seen(), options_.rival_share});
    candidate->reason = RefusalReason(candidate->match, options_.max_score, options_.min_overlap);
  }
  candidate->accepted = candidate->reason.empty();
}

}  // namespace arborslam
