#include "backend/loop/place_recognizer.h"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <utility>

#include "core/config/validation.h"

namespace arborslam {
namespace {

// Places whose ring keys are nearest, as many of them are compared bin by bin.
constexpr size_t kNumPreselected = 400;
// Two candidates farther apart than this are two answers.
constexpr double kSamePlaceTranslation = 0.5;  // [m]
constexpr double kSamePlaceRotation = 0.1;     // [rad]

// For each keyframe the submap that it is a member of, if any; of several the one whose ends are farther away.
std::vector<std::optional<size_t>> HomeSubmaps(size_t num_keyframes, const std::vector<Submap>& submaps) {
  std::vector<std::optional<size_t>> homes(num_keyframes);
  std::vector<size_t> depths(num_keyframes, 0);
  for (size_t s = 0; s < submaps.size(); ++s) {
    const std::vector<KeyframeId>& members = submaps[s].keyframes;
    for (size_t i = 0; i < members.size(); ++i) {
      const auto keyframe = static_cast<size_t>(members[i].value);
      const size_t depth = std::min(i, members.size() - 1 - i);
      if (homes[keyframe] && depths[keyframe] >= depth) continue;
      homes[keyframe] = s;
      depths[keyframe] = depth;
    }
  }
  return homes;
}

// Of the way between two poses, by how much maps may place them differently.
constexpr double kBend = 0.01;

}  // namespace

bool AgreeOnPlace(const SE2& T_map_one, const SE2& T_known_one, const SE2& T_map_other, const SE2& T_known_other,
                  double translation, double rotation) {
  const SE2 way = T_known_one.Inverse() * T_known_other;
  return AreClose(T_map_one * way, T_map_other, translation + kBend * way.translation().norm(), rotation);
}

std::string PlaceOptions::Validate() const {
  if (!(max_range > 0.0)) return Violation("max_range", max_range, "be above 0 m");
  if (!(spacing >= 0.0)) return Violation("spacing", spacing, "be at least 0 m");
  if (num_candidates < 1 || num_candidates > 1000) {
    return Violation("num_candidates", num_candidates, "lie in [1, 1000]");
  }
  if (!(search_translation > 0.0 && search_translation <= 20.0)) {
    return Violation("search_translation", search_translation, "lie in (0, 20] m");
  }
  if (!(search_rotation > 0.0 && search_rotation <= 3.15)) {
    return Violation("search_rotation", search_rotation, "lie in (0, 3.15] rad");
  }
  if (!(max_score > 0.0)) return Violation("max_score", max_score, "be above 0 m");
  if (!(min_overlap >= 0.0 && min_overlap <= 1.0)) return Violation("min_overlap", min_overlap, "lie in [0, 1]");
  if (!(rival_translation > 0.0 && rival_translation <= 50.0)) {
    return Violation("rival_translation", rival_translation, "lie in (0, 50] m");
  }
  return "";
}

// The ring keys as nanoflann wants them.
class PlaceRecognizer::Index {
 public:
  explicit Index(const std::vector<Place>& places) : places_(places), tree_(PlaceDescriptor::kNumRings, *this) {
    tree_.buildIndex();
  }

  std::vector<size_t> FindNearest(const PlaceDescriptor::RingKey& key, size_t count) const {
    std::vector<size_t> indices(std::min(count, places_.size()));
    std::vector<float> squared_distances(indices.size());
    const size_t found = tree_.knnSearch(key.data(), indices.size(), indices.data(), squared_distances.data());
    indices.resize(found);
    return indices;
  }

  size_t kdtree_get_point_count() const { return places_.size(); }
  float kdtree_get_pt(size_t index, size_t dimension) const {
    return places_[index].descriptor.ring_key(static_cast<Eigen::Index>(dimension));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Index>, Index,
                                                   PlaceDescriptor::kNumRings, size_t>;
  const std::vector<Place>& places_;
  Tree tree_;
};

PlaceRecognizer::PlaceRecognizer(const PlaceOptions& options, const Matcher& matcher, double max_second_ratio,
                                 const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                 const std::vector<Submap>& submaps)
    : options_(options), matcher_(matcher), max_second_ratio_(max_second_ratio), graph_(graph), submaps_(submaps) {
  const std::vector<std::optional<size_t>> homes = HomeSubmaps(keyframes.size(), submaps);
  std::optional<SE2> last;
  for (const Keyframe& keyframe : keyframes) {
    const std::optional<size_t>& home = homes[static_cast<size_t>(keyframe.id.value)];
    if (!home || !keyframe.is_inserted) continue;
    const SE2& pose = graph.Pose(keyframe.id);
    if (last && (pose.translation() - last->translation()).norm() < options.spacing) continue;
    last = pose;
    places_.push_back({keyframe.id, *home, DescribePlace(keyframe.scan.Get()->points, options.max_range)});
  }
  index_ = std::make_unique<Index>(places_);
}

PlaceRecognizer::~PlaceRecognizer() = default;

std::vector<size_t> PlaceRecognizer::Preselect(const PlaceDescriptor::RingKey& key,
                                               const std::function<bool(size_t)>& is_possible) const {
  if (!is_possible) return index_->FindNearest(key, kNumPreselected);
  std::vector<std::pair<float, size_t>> distances;
  for (size_t i = 0; i < places_.size(); ++i) {
    if (!is_possible(places_[i].submap_index)) continue;
    distances.emplace_back((places_[i].descriptor.ring_key - key).squaredNorm(), i);
  }
  std::sort(distances.begin(), distances.end());
  distances.resize(std::min(distances.size(), kNumPreselected));
  std::vector<size_t> indices;
  for (const auto& [distance, index] : distances) indices.push_back(index);
  return indices;
}

std::vector<PlaceCandidate> PlaceRecognizer::FindAlike(const PlaceDescriptor& query,
                                                       const std::function<bool(size_t)>& is_possible) const {
  std::vector<PlaceCandidate> alike;
  for (const size_t index : Preselect(query.ring_key, is_possible)) {
    const Place& place = places_[index];
    const PlaceSimilarity similarity = ComparePlaces(query, place.descriptor);
    PlaceCandidate candidate{place.keyframe, place.submap_index, similarity.value, {}, {}};
    candidate.T_map_base = graph_.Pose(place.keyframe) * SE2(0.0, 0.0, similarity.yaw);
    alike.push_back(std::move(candidate));
  }
  std::sort(alike.begin(), alike.end(), [](const PlaceCandidate& a, const PlaceCandidate& b) {
    return a.similarity != b.similarity ? a.similarity > b.similarity : a.keyframe < b.keyframe;
  });
  // Neighbours on a path look alike; one search covers them.
  std::vector<PlaceCandidate> kept;
  for (PlaceCandidate& candidate : alike) {
    if (kept.size() == static_cast<size_t>(options_.num_candidates)) break;
    const bool is_covered = std::any_of(kept.begin(), kept.end(), [&](const PlaceCandidate& other) {
      return other.submap_index == candidate.submap_index &&
             AreClose(other.T_map_base, candidate.T_map_base, 0.5 * options_.search_translation,
                      0.75 * options_.search_rotation);
    });
    if (!is_covered) kept.push_back(std::move(candidate));
  }
  return kept;
}

PlaceRecognition PlaceRecognizer::Recognize(const std::vector<Eigen::Vector2f>& points, SubmapTargets* targets,
                                            const std::function<bool(size_t)>& is_possible) const {
  PlaceRecognition result;
  if (places_.empty()) {
    result.reason = "no places";
    return result;
  }
  result.candidates = FindAlike(DescribePlace(points, options_.max_range), is_possible);
  // To rule out a rival the best of them must be known first.
  const SearchWindow window{options_.search_translation, options_.search_rotation, 0.02, {}};
  const double max_cost = options_.max_score / max_second_ratio_;
  std::optional<size_t> best;
  for (size_t i = 0; i < result.candidates.size(); ++i) {
    PlaceCandidate& candidate = result.candidates[i];
    const SE2& T_map_submap = graph_.Pose(submaps_[candidate.submap_index].id);
    candidate.match = matcher_.MatchBetter(targets->Get(candidate.submap_index), points,
                                           T_map_submap.Inverse() * candidate.T_map_base, window, max_cost);
    candidate.T_map_base = T_map_submap * candidate.match.pose;
    if (!IsUsable(candidate.match.verdict)) continue;
    if (!best || candidate.match.score < result.candidates[*best].match.score) best = i;
  }
  if (!best) {
    result.reason = ToString(MatchVerdict::kPoor);
    return result;
  }
  PlaceCandidate& winner = result.candidates[*best];
  for (const PlaceCandidate& other : result.candidates) {
    if (!IsUsable(other.match.verdict) || other.match.score * max_second_ratio_ >= winner.match.score) continue;
    if (AreClose(other.T_map_base, winner.T_map_base, kSamePlaceTranslation, kSamePlaceRotation)) continue;
    winner.match.verdict = MatchVerdict::kAmbiguous;
    winner.match.second_score = other.match.score;
  }
  result.reason = winner.match.verdict == MatchVerdict::kDegenerate
                      ? ToString(winner.match.verdict)
                      : RefusalReason(winner.match, options_.max_score, options_.min_overlap);
  if (result.reason.empty()) {
    matcher_.CheckUniqueness(targets->Get(winner.submap_index), points,
                             SearchWindow{options_.rival_translation, options_.search_rotation, 0.02, {}},
                             &winner.match);
    result.reason = RefusalReason(winner.match, options_.max_score, options_.min_overlap);
  }
  if (result.reason.empty()) result.best = best;
  return result;
}

}  // namespace arborslam
