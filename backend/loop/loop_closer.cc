#include "backend/loop/loop_closer.h"

#include <algorithm>
#include <nanoflann.hpp>
#include <set>

#include "core/config/validation.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// Keyframe positions as nanoflann wants them.
struct Positions {
  std::vector<Eigen::Vector2d> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t index, size_t dimension) const {
    return points[index](static_cast<Eigen::Index>(dimension));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Positions>, Positions, 2>;

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
  if (!(max_score > 0.0)) return Violation("max_score", max_score, "be above 0 m");
  if (!(min_overlap >= 0.0 && min_overlap <= 1.0)) return Violation("min_overlap", min_overlap, "lie in [0, 1]");
  return "";
}

LoopCloser::LoopCloser(const LoopOptions& options, const MatcherOptions& matcher_options, const Matcher& matcher,
                       double cell_size)
    : options_(options), max_distance_(matcher_options.max_distance), matcher_(matcher), cell_size_(cell_size) {}

std::vector<LoopCandidate> LoopCloser::FindAll(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                               const std::vector<Submap>& submaps, int num_threads) const {
  Positions positions;
  for (const Keyframe& keyframe : keyframes) positions.points.push_back(graph.Pose(keyframe.id).translation());
  KdTree tree(2, positions);
  tree.buildIndex();
  std::set<std::pair<int, int>> known;
  for (const Constraint& constraint : graph.constraints()) {
    if (constraint.from.kind == NodeId::Kind::kSubmap) known.emplace(constraint.from.value, constraint.to.value);
  }

  std::vector<std::vector<LoopCandidate>> found(submaps.size());
  ParallelFor(submaps.size(), num_threads, [&](size_t i) {
    const Submap& submap = submaps[i];
    std::set<int> near;
    for (const KeyframeId member : submap.keyframes) {
      std::vector<std::pair<uint32_t, double>> hits;
      tree.radiusSearch(positions.points[static_cast<size_t>(member.value)].data(),
                        options_.candidate_radius * options_.candidate_radius, hits, nanoflann::SearchParams());
      for (const auto& hit : hits) near.insert(static_cast<int>(hit.first));
    }
    for (const KeyframeId member : submap.keyframes) near.erase(member.value);
    std::unique_ptr<MatchTarget> target;
    const SE2 T_submap_map = graph.Pose(submap.id).Inverse();
    for (const int index : near) {
      const Keyframe& keyframe = keyframes[static_cast<size_t>(index)];
      if (index % options_.keyframe_stride != 0 || !keyframe.is_inserted) continue;
      if (known.count({submap.id.value, index}) > 0) continue;
      if (!target) target = std::make_unique<MatchTarget>(submap.cells, cell_size_, max_distance_);
      const SearchWindow window{options_.search_translation, options_.search_rotation, 0.01, {}};
      LoopCandidate candidate{keyframe.id, submap.id, {}, false, ""};
      candidate.match =
          matcher_.Match(*target, keyframe.scan.points, T_submap_map * graph.Pose(keyframe.id), window, true);
      if (!IsUsable(candidate.match.verdict)) {
        candidate.reason = ToString(candidate.match.verdict);
      } else if (candidate.match.score > options_.max_score) {
        candidate.reason = "score";
      } else if (candidate.match.inlier_ratio < options_.min_overlap) {
        candidate.reason = "overlap";
      }
      candidate.accepted = candidate.reason.empty();
      found[i].push_back(candidate);
    }
  });
  std::vector<LoopCandidate> candidates;
  for (const auto& of_submap : found) candidates.insert(candidates.end(), of_submap.begin(), of_submap.end());
  return candidates;
}

}  // namespace arborslam
