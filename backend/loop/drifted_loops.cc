#include "backend/loop/drifted_loops.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "backend/graph/map_parts.h"
#include "backend/loop/relative_uncertainty.h"
#include "backend/loop/submap_path.h"
#include "backend/loop/submap_targets.h"
#include "core/geometry/angles.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// [m] of path between keyframes that are asked.
constexpr double kSpacing = 1.0;
// [m] of path within which answers vote on one drift.
constexpr double kStretch = 40.0;
// Answers agree to within these, see `AgreeOnPlace`.
constexpr double kVoteTranslation = 0.5;  // [m]
constexpr double kVoteRotation = 0.1;     // [rad]
// More than so many times as many must agree as contradict.
constexpr size_t kMinRatio = 4;
// Drift of a long way is hardly ever as small as its covariance says: corridors and rows bend maps all the same way.
// So many times the window of the covariance are believed.
constexpr double kDoubt = 3.0;
// [m] of path: two pieces of this length with a loop between them have not drifted apart.
constexpr double kPiece = 20.0;
// [m], where a scan of an unjoined part of the map may be.
constexpr double kAnywhere = 1e6;
// Match targets that are kept for neighbouring keyframes.
constexpr size_t kNumTargets = 8;
// Keyframes per piece of work: neighbours share targets.
constexpr size_t kChunk = 50;

// A keyframe that is asked.
struct Question {
  size_t keyframe;
  std::vector<char> is_possible;  // By submap: it may be there that the keyframe was taken.
};

struct Answer {
  LoopCandidate loop;
  SE2 T_map_base;    // As recognised,
  SE2 T_graph_base;  // and by the graph.
  double path;       // [m] along the run's path, of the keyframe,
  double path_then;  // and of the one whose place it recognised.
};

// [m] from the first keyframe to each.
std::vector<double> PathLengths(const PoseGraph& graph, const std::vector<Keyframe>& keyframes) {
  std::vector<double> lengths{0.0};
  for (size_t i = 1; i < keyframes.size(); ++i) {
    const Eigen::Vector2d step =
        graph.Pose(keyframes[i].id).translation() - graph.Pose(keyframes[i - 1].id).translation();
    lengths.push_back(lengths.back() + step.norm());
  }
  return lengths;
}

// Which pieces of the path a loop has joined.
class JoinedPieces {
 public:
  void Add(double path_a, double path_b) {
    joined_.emplace(PieceOf(path_a), PieceOf(path_b));
    joined_.emplace(PieceOf(path_b), PieceOf(path_a));
  }

  // True if the pieces of the two, or neighbours of them, are.
  bool Are(double path_a, double path_b) const {
    for (int a = -1; a <= 1; ++a) {
      for (int b = -1; b <= 1; ++b) {
        if (joined_.count({PieceOf(path_a) + a, PieceOf(path_b) + b}) > 0) return true;
      }
    }
    return false;
  }

 private:
  static int PieceOf(double path) { return static_cast<int>(path / kPiece); }

  std::set<std::pair<int, int>> joined_;
};

double MiddleOf(const Submap& submap, const std::vector<double>& path) {
  return path[static_cast<size_t>(submap.keyframes[submap.keyframes.size() / 2].value)];
}

JoinedPieces PiecesJoinedBy(const PoseGraph& graph, const std::vector<Submap>& submaps,
                            const std::vector<double>& path) {
  std::map<int, double> middles;
  for (const Submap& submap : submaps) middles[submap.id.value] = MiddleOf(submap, path);
  JoinedPieces pieces;
  for (const Constraint& constraint : graph.constraints()) {
    if (constraint.kind != Constraint::Kind::kLoop || constraint.from.kind != NodeId::Kind::kSubmap) continue;
    const auto middle = middles.find(constraint.from.value);
    if (middle != middles.end()) pieces.Add(middle->second, path[static_cast<size_t>(constraint.to.value)]);
  }
  return pieces;
}

std::vector<Question> Spaced(const std::vector<Keyframe>& keyframes, const std::vector<double>& path,
                             size_t num_submaps) {
  std::vector<Question> questions;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    if (!keyframes[i].is_inserted) continue;
    if (!questions.empty() && path[i] - path[questions.back().keyframe] < kSpacing) continue;
    questions.push_back({i, std::vector<char>(num_submaps, 0)});
  }
  return questions;
}

// The keyframes that may see submaps from which they have drifted beyond all windows, in their order.
std::vector<Question> QuestionsOf(const LoopOptions& options, const PoseGraph& graph,
                                  const RelativeUncertainty& uncertainty, const std::vector<Keyframe>& keyframes,
                                  const std::vector<double>& path, const std::vector<Submap>& submaps,
                                  int num_threads) {
  std::vector<Question> questions = Spaced(keyframes, path, submaps.size());
  const JoinedPieces pieces = PiecesJoinedBy(graph, submaps, path);
  const MapParts parts(graph);
  ParallelFor(submaps.size(), num_threads, [&](size_t s) {
    const double middle = MiddleOf(submaps[s], path);
    const SubmapPath submap_path(submaps[s], graph);
    const RelativeUncertainty::View view = uncertainty.From(submaps[s].id);
    for (Question& question : questions) {
      if (!parts.AreJoined(submaps[s].id, keyframes[question.keyframe].id)) {
        question.is_possible[s] = 1;
        continue;
      }
      if (pieces.Are(middle, path[question.keyframe])) continue;
      const KeyframeId id = keyframes[question.keyframe].id;
      const std::optional<Eigen::Matrix3d> covariance = view.Of(id);
      if (!covariance) continue;
      const SearchedWindow window = WindowOf(*covariance);
      if (window.translation <= options.max_search_translation && window.rotation <= options.max_search_rotation) {
        continue;
      }
      const double reach = options.candidate_radius + kDoubt * window.translation;
      question.is_possible[s] = submap_path.DistanceTo(graph.Pose(id).translation(), reach) <= reach ? 1 : 0;
    }
  });
  const auto is_sure = [](const Question& question) {
    return std::find(question.is_possible.begin(), question.is_possible.end(), 1) == question.is_possible.end();
  };
  questions.erase(std::remove_if(questions.begin(), questions.end(), is_sure), questions.end());
  return questions;
}

// True if both tell of one drift, or should: both are of one stretch, and recognise what came before it, or after.
bool AreComparable(const Answer& one, const Answer& other) {
  return std::abs(other.path - one.path) <= kStretch && (one.path < one.path_then) == (other.path < other.path_then);
}

bool Agree(const Answer& one, const Answer& other) {
  return AgreeOnPlace(one.T_map_base, one.T_graph_base, other.T_map_base, other.T_graph_base, kVoteTranslation,
                      kVoteRotation);
}

// Accepts the answers that enough others agree with.
void Vote(size_t min_votes, std::vector<Answer>* answers) {
  for (Answer& one : *answers) {
    if (!one.loop.reason.empty()) continue;
    size_t num_agreeing = 0;
    size_t num_contradicting = 0;
    for (const Answer& other : *answers) {
      if (!other.loop.reason.empty() || !AreComparable(one, other)) continue;
      if (Agree(one, other)) {
        ++num_agreeing;
      } else if (std::abs(other.path_then - one.path_then) <= 2.0 * kStretch) {
        ++num_contradicting;
      }
    }
    one.loop.accepted = num_agreeing >= min_votes && num_agreeing > kMinRatio * num_contradicting;
  }
  for (Answer& answer : *answers) {
    if (!answer.loop.accepted && answer.loop.reason.empty()) answer.loop.reason = "too few agree";
  }
}

}  // namespace

DriftedLoopFinder::DriftedLoopFinder(const LoopOptions& options, const PlaceOptions& place,
                                     const MatcherOptions& matcher_options, const Matcher& matcher, double cell_size)
    : options_(options),
      place_options_(place),
      matcher_options_(matcher_options),
      matcher_(matcher),
      cell_size_(cell_size) {}

std::vector<LoopCandidate> DriftedLoopFinder::FindAll(const PoseGraph& graph, const std::vector<Keyframe>& keyframes,
                                                      const std::vector<Submap>& submaps, int num_threads) const {
  if (options_.drift_votes == 0 || keyframes.empty()) return {};
  const RelativeUncertainty uncertainty(graph);
  const std::vector<double> path = PathLengths(graph, keyframes);
  const std::vector<Question> questions =
      QuestionsOf(options_, graph, uncertainty, keyframes, path, submaps, num_threads);
  if (questions.empty()) return {};

  const PlaceRecognizer recognizer(place_options_, matcher_, matcher_options_.max_second_ratio, graph, keyframes,
                                   submaps);
  std::vector<std::optional<Answer>> given(questions.size());
  const auto ask = [&](const Question& question, SubmapTargets* targets) -> std::optional<Answer> {
    const Keyframe& keyframe = keyframes[question.keyframe];
    const PlaceRecognition recognition = recognizer.Recognize(
        keyframe.scan.Get()->points, targets, [&question](size_t submap) { return question.is_possible[submap] != 0; });
    if (!recognition.best) return std::nullopt;
    const PlaceCandidate& found = recognition.candidates[*recognition.best];
    const SubmapId submap = submaps[found.submap_index].id;
    const SE2& T_graph_base = graph.Pose(keyframe.id);
    // Of another part of the map nothing is known.
    const std::optional<Eigen::Matrix3d> covariance = uncertainty.From(submap).Of(keyframe.id);
    const SearchedWindow window = covariance ? WindowOf(*covariance) : SearchedWindow{kAnywhere, kPi};
    const double turn = NormalizeAngle(found.T_map_base.theta() - T_graph_base.theta());
    const bool is_explained = !covariance || std::abs(turn) <= kDoubt * window.rotation;
    return Answer{{keyframe.id, submap, graph.Pose(submap).Inverse() * T_graph_base, window.translation,
                   window.rotation, found.match, false, is_explained ? "" : "impossible drift"},
                  found.T_map_base,
                  T_graph_base,
                  path[question.keyframe],
                  path[static_cast<size_t>(found.keyframe.value)]};
  };
  ParallelFor((questions.size() + kChunk - 1) / kChunk, num_threads, [&](size_t chunk) {
    SubmapTargets targets(submaps, cell_size_, matcher_options_.max_distance, kNumTargets);
    for (size_t i = chunk * kChunk; i < std::min(questions.size(), (chunk + 1) * kChunk); ++i) {
      given[i] = ask(questions[i], &targets);
    }
  });
  std::vector<Answer> answers;
  for (std::optional<Answer>& answer : given) {
    if (answer) answers.push_back(std::move(*answer));
  }
  Vote(static_cast<size_t>(options_.drift_votes), &answers);
  std::vector<LoopCandidate> loops;
  loops.reserve(answers.size());
  for (Answer& answer : answers) loops.push_back(std::move(answer.loop));
  return loops;
}

}  // namespace arborslam
