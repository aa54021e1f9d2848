#ifndef ARBORSLAM_BACKEND_MERGE_PLACE_VOTES_H_
#define ARBORSLAM_BACKEND_MERGE_PLACE_VOTES_H_

#include <cstddef>
#include <string>
#include <vector>

#include "backend/loop/place_recognizer.h"
#include "backend/slam_options.h"
#include "backend/store/session_contents.h"
#include "core/geometry/se2.h"
#include "core/map/ids.h"
#include "frontend/matching/matcher.h"

namespace arborslam {

struct MergeOptions {
  double spacing = 1.0;           ///< [m] between the keyframes that are asked where they were taken.
  int min_votes = 5;              ///< So many answers must agree on where one map lies in the other,
  double min_ratio = 4.0;         ///< and more than this times as many as agree on any other place.
  double vote_translation = 0.5;  ///< [m], answers agree when each places the other's keyframe no farther off than
                                  ///< this, and, both maps being bent a little, 1 % of the way between them;
  double vote_rotation = 0.1;     ///< [rad], and turns it no farther off than this.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("spacing", spacing);
    visit("min_votes", min_votes);
    visit("min_ratio", min_ratio);
    visit("vote_translation", vote_translation);
    visit("vote_rotation", vote_rotation);
  }
};

/// What a keyframe of map b tells of where it lies in map a.
struct PlaceVote {
  KeyframeId keyframe;  ///< Of map b.
  SubmapId submap;      ///< Of map a: the one in which it was recognised.
  MatchResult match;    ///< Pose T_submap_keyframe.
  SE2 T_a_keyframe;
  SE2 T_b_keyframe;
};

/// Where a map lies in another, as its keyframes tell one by one.
struct PlaceVotes {
  size_t num_asked = 0;             ///< Keyframes of map b.
  size_t num_recognized = 0;        ///< Those of them that recognised a place.
  std::vector<PlaceVote> agreeing;  ///< The greatest number of answers that agree, in the order of the keyframes.
  size_t num_rivals = 0;            ///< The greatest number that agree among those that are left.
  SE2 T_a_b;                        ///< As those that agree have it in the mean; only when there is no `reason`.
  std::string reason;               ///< Why they do not tell; empty if they do.
};

/// "21 keyframes asked, 20 recognised a place, 19 agree on one, 0 on another".
std::string TextOf(const PlaceVotes& votes);

/// "(1.250 m, -3.000 m, 0.5000 rad)", as messages tell where a map lies.
std::string TextOf(const SE2& pose);

/// Asks the keyframes of map `b` about every `MergeOptions::spacing` metres where in map `a` they were taken, without
/// any prior (`PlaceRecognizer`), and whether enough of them agree. Single answers are wrong now and then in a world
/// that repeats itself, but they do not agree with each other; and what does repeat as a whole shows in a rival that
/// as many agree on. The same for any number of threads.
PlaceVotes VoteOnPlace(const SlamOptions& options, const MergeOptions& merge, const SessionContents& a,
                       const SessionContents& b, int num_threads);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_MERGE_PLACE_VOTES_H_
