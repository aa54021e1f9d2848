#ifndef ARBORSLAM_BACKEND_LOOP_PLACE_RECOGNIZER_H_
#define ARBORSLAM_BACKEND_LOOP_PLACE_RECOGNIZER_H_

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/loop/place_descriptor.h"
#include "backend/loop/submap_targets.h"
#include "core/map/submap.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

struct PlaceOptions {
  double max_range = 15.0;          ///< [m], what is farther away does not describe a place.
  double spacing = 0.5;             ///< [m] of path between the places that are remembered.
  int num_candidates = 12;          ///< Places most alike that a scan is matched to.
  double search_translation = 1.5;  ///< [m], half width of the search around a remembered place.
  double search_rotation = 0.15;    ///< [rad], the same in heading.
  double max_score = 0.08;          ///< [m], the MHD of a recognised place may not exceed this.
  double min_overlap = 0.6;         ///< Share of the scan's points that must meet the map.
  double rival_translation = 5.0;   ///< [m], so far around a pose there may be no second one nearly as good.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("max_range", max_range);
    visit("spacing", spacing);
    visit("num_candidates", num_candidates);
    visit("search_translation", search_translation);
    visit("search_rotation", search_rotation);
    visit("max_score", max_score);
    visit("min_overlap", min_overlap);
    visit("rival_translation", rival_translation);
  }
};

/// A place that a scan was matched to.
struct PlaceCandidate {
  KeyframeId keyframe;      ///< Whose place it looks like.
  size_t submap_index = 0;  ///< Into the map's submaps: the one that it was matched to.
  double similarity = 0.0;  ///< Of the descriptors, see `PlaceSimilarity`.
  MatchResult match;        ///< Pose T_submap_base.
  SE2 T_map_base;
};

/// Where a scan was taken, as far as it tells.
struct PlaceRecognition {
  std::vector<PlaceCandidate> candidates;  ///< Those tried, in the order of their similarity.
  /// The one of them that is best and passed all checks; nothing if the scan does not tell.
  std::optional<size_t> best;
  std::string reason;  ///< Why there is none; empty if there is.
};

/// True if two poses of something that is known in another frame, or less well, are recognised in the map such that
/// they agree on where it lies there: each places the other no farther off than `translation` [m] and, maps being bent
/// a little, 1 % of the way between them, and turns it no farther off than `rotation` [rad].
bool AgreeOnPlace(const SE2& T_map_one, const SE2& T_known_one, const SE2& T_map_other, const SE2& T_known_other,
                  double translation, double rotation);

/// Tells where in a map a scan was taken, without any prior: places that look alike by their descriptors are matched
/// by branch and bound, and the best match counts only if it is clean and without rival, that is if neither another
/// candidate elsewhere nor any pose within `rival_translation` around it (a tree or a row away) is nearly as good.
/// A single answer may still be wrong, where a world repeats itself farther off than the candidates tell; who cannot
/// bear that asks with several scans (`Localizer`). Immutable: may be asked from several threads.
class PlaceRecognizer {
 public:
  /// @param graph, keyframes, submaps the map, keyframe i with id i; must outlive this object.
  PlaceRecognizer(const PlaceOptions& options, const Matcher& matcher, double max_second_ratio, const PoseGraph& graph,
                  const std::vector<Keyframe>& keyframes, const std::vector<Submap>& submaps);
  ~PlaceRecognizer();

  /// @param points  [m], base frame.
  /// @param targets of the same submaps; the calling thread's own.
  /// @param is_possible of a submap's index: places in others are no candidates. Nothing: all are.
  PlaceRecognition Recognize(const std::vector<Eigen::Vector2f>& points, SubmapTargets* targets,
                             const std::function<bool(size_t)>& is_possible = nullptr) const;

 private:
  struct Place {
    KeyframeId keyframe;
    size_t submap_index;  // In whose middle the keyframe lies most.
    PlaceDescriptor descriptor;
  };
  class Index;

  // The possible places that look most like `query`, best first.
  std::vector<PlaceCandidate> FindAlike(const PlaceDescriptor& query,
                                        const std::function<bool(size_t)>& is_possible) const;
  // Those whose ring keys are nearest to `key`, as indices.
  std::vector<size_t> Preselect(const PlaceDescriptor::RingKey& key,
                                const std::function<bool(size_t)>& is_possible) const;

  PlaceOptions options_;
  Matcher matcher_;
  double max_second_ratio_;
  const PoseGraph& graph_;
  const std::vector<Submap>& submaps_;
  std::vector<Place> places_;
  std::unique_ptr<Index> index_;  // Over the ring keys.
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOOP_PLACE_RECOGNIZER_H_
