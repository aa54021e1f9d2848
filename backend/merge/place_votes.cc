#include "backend/merge/place_votes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include "backend/loop/submap_targets.h"
#include "core/config/validation.h"
#include "core/evaluation/alignment.h"
#include "core/parallel.h"

namespace arborslam {
namespace {

// [m], how far ahead of a keyframe a second point stands for its heading when a mean is taken.
constexpr double kAhead = 5.0;
// Match targets that are kept for neighbouring keyframes.
constexpr size_t kNumTargets = 8;

// The clean keyframes of a map, no two in a row nearer to each other than `spacing` [m].
std::vector<const Keyframe*> SpacedKeyframes(const SessionContents& map, double spacing) {
  std::vector<const Keyframe*> spaced;
  for (const Keyframe& keyframe : map.keyframes) {
    if (!keyframe.is_inserted) continue;
    const Eigen::Vector2d& position = map.graph.Pose(keyframe.id).translation();
    if (!spaced.empty() && (position - map.graph.Pose(spaced.back()->id).translation()).norm() < spacing) continue;
    spaced.push_back(&keyframe);
  }
  return spaced;
}

// What each of `asked` answers.
std::vector<std::optional<PlaceVote>> Ask(const std::vector<const Keyframe*>& asked, const SlamOptions& options,
                                          const SessionContents& a, const SessionContents& b, int num_threads) {
  const Matcher matcher(options.matcher, options.mhd, options.refinement);
  const PlaceRecognizer recognizer(options.place, matcher, options.matcher.max_second_ratio, a.graph, a.keyframes,
                                   a.submaps);
  std::vector<std::optional<PlaceVote>> votes(asked.size());
  // Neighbours share targets.
  const auto num_shares = static_cast<size_t>(num_threads);
  ParallelFor(num_shares, num_threads, [&](size_t share) {
    SubmapTargets targets(a.submaps, options.grid.cell_size, options.matcher.max_distance, kNumTargets);
    for (size_t i = share * asked.size() / num_shares; i < (share + 1) * asked.size() / num_shares; ++i) {
      const PlaceRecognition recognition = recognizer.Recognize(asked[i]->scan.Get()->points, &targets);
      if (!recognition.best) continue;
      const PlaceCandidate& found = recognition.candidates[*recognition.best];
      votes[i] = PlaceVote{asked[i]->id, a.submaps[found.submap_index].id, found.match, found.T_map_base,
                           b.graph.Pose(asked[i]->id)};
    }
  });
  return votes;
}

bool Agree(const PlaceVote& one, const PlaceVote& other, const MergeOptions& options) {
  return AgreeOnPlace(one.T_a_keyframe, one.T_b_keyframe, other.T_a_keyframe, other.T_b_keyframe,
                      options.vote_translation, options.vote_rotation);
}

// Takes out of `votes` those that agree with the one that most agree with; of several such, the first.
std::vector<PlaceVote> TakeLargestParty(const MergeOptions& options, std::vector<PlaceVote>* votes) {
  const auto count = [&](const PlaceVote& one) {
    return std::count_if(votes->begin(), votes->end(),
                         [&](const PlaceVote& other) { return Agree(one, other, options); });
  };
  std::optional<PlaceVote> leader;
  std::ptrdiff_t most = 0;
  for (const PlaceVote& vote : *votes) {
    const std::ptrdiff_t followers = count(vote);
    if (followers <= most) continue;
    most = followers;
    leader = vote;
  }
  if (!leader) return {};
  const auto rest = std::stable_partition(votes->begin(), votes->end(),
                                          [&](const PlaceVote& vote) { return Agree(*leader, vote, options); });
  std::vector<PlaceVote> party(votes->begin(), rest);
  votes->erase(votes->begin(), rest);
  return party;
}

// T_a_b that fits positions and headings best.
SE2 MeanPlace(const std::vector<PlaceVote>& votes) {
  Eigen::Matrix2Xd in_a(2, 2 * static_cast<Eigen::Index>(votes.size()));
  Eigen::Matrix2Xd in_b = in_a;
  Eigen::Index column = 0;
  for (const PlaceVote& vote : votes) {
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(kAhead, 0.0)}) {
      in_a.col(column) = vote.T_a_keyframe * point;
      in_b.col(column) = vote.T_b_keyframe * point;
      ++column;
    }
  }
  return UmeyamaSe2(in_b, in_a);
}

}  // namespace

std::string MergeOptions::Validate() const {
  if (!(spacing >= 0.0)) return Violation("spacing", spacing, "be at least 0 m");
  if (min_votes < 2) return Violation("min_votes", min_votes, "be at least 2");
  if (!(min_ratio >= 1.0)) return Violation("min_ratio", min_ratio, "be at least 1");
  if (!(vote_translation > 0.0)) return Violation("vote_translation", vote_translation, "be above 0 m");
  if (!(vote_rotation > 0.0)) return Violation("vote_rotation", vote_rotation, "be above 0 rad");
  return "";
}

std::string TextOf(const PlaceVotes& votes) {
  return std::to_string(votes.num_asked) + " keyframes asked, " + std::to_string(votes.num_recognized) +
         " recognised a place, " + std::to_string(votes.agreeing.size()) + " agree on one, " +
         std::to_string(votes.num_rivals) + " on another";
}

std::string TextOf(const SE2& pose) {
  char text[96];
  std::snprintf(text, sizeof(text), "(%.3f m, %.3f m, %.4f rad)", pose.x(), pose.y(), pose.theta());
  return text;
}

PlaceVotes VoteOnPlace(const SlamOptions& options, const MergeOptions& merge, const SessionContents& a,
                       const SessionContents& b, int num_threads) {
  PlaceVotes result;
  const std::vector<const Keyframe*> asked = SpacedKeyframes(b, merge.spacing);
  result.num_asked = asked.size();
  std::vector<PlaceVote> votes;
  for (std::optional<PlaceVote>& vote : Ask(asked, options, a, b, num_threads)) {
    if (vote) votes.push_back(std::move(*vote));
  }
  result.num_recognized = votes.size();
  result.agreeing = TakeLargestParty(merge, &votes);
  result.num_rivals = TakeLargestParty(merge, &votes).size();
  if (result.agreeing.size() < static_cast<size_t>(merge.min_votes)) {
    result.reason = "too few agree";
  } else if (static_cast<double>(result.agreeing.size()) <= merge.min_ratio * static_cast<double>(result.num_rivals)) {
    result.reason = "too many agree on another place";
  } else {
    result.T_a_b = MeanPlace(result.agreeing);
  }
  return result;
}

}  // namespace arborslam
