#include "backend/merge/session_merger.h"

#include <algorithm>
#include <map>
#include <utility>

#include "backend/terrain/scan_tilts.h"

namespace arborslam {
namespace {

// How ids of a session are counted on behind those of another.
struct IdShift {
  int keyframes = 0;
  int submaps = 0;

  explicit IdShift(const SessionContents& before) : keyframes(static_cast<int>(before.keyframes.size())) {
    submaps = static_cast<int>(before.graph.poses().size()) - keyframes;
  }

  KeyframeId operator()(KeyframeId id) const { return KeyframeId{id.value + keyframes}; }
  SubmapId operator()(SubmapId id) const { return SubmapId{id.value + submaps}; }
  NodeId operator()(NodeId id) const {
    id.value += id.kind == NodeId::Kind::kKeyframe ? keyframes : submaps;
    return id;
  }
};

// Adds all of `next`, whose map lies at T_a_b in that of `merged`.
void Append(const SessionContents& next, const IdShift& shift, const SE2& T_a_b, SessionContents* merged) {
  merged->recordings.insert(merged->recordings.end(), next.recordings.begin(), next.recordings.end());
  merged->read.insert(merged->read.end(), next.read.begin(), next.read.end());
  for (PosedScan scan : next.scans) {
    scan.keyframe = shift(scan.keyframe);
    merged->scans.push_back(std::move(scan));
  }
  for (Keyframe keyframe : next.keyframes) {
    keyframe.id = shift(keyframe.id);
    merged->keyframes.push_back(std::move(keyframe));
  }
  for (Submap submap : next.submaps) {
    submap.id = shift(submap.id);
    for (KeyframeId& id : submap.keyframes) id = shift(id);
    merged->submaps.push_back(std::move(submap));
  }
  for (const auto& [id, pose] : next.graph.poses()) merged->graph.AddNode(shift(id), T_a_b * pose);
  for (Constraint constraint : next.graph.constraints()) {
    constraint.from = shift(constraint.from);
    constraint.to = shift(constraint.to);
    merged->graph.AddConstraint(constraint);
  }
}

}  // namespace

SessionMerger::SessionMerger(const SlamOptions& options, const MergeOptions& merge, int num_threads,
                             SessionContents first)
    : options_(options),
      merge_(merge),
      num_threads_(num_threads),
      matcher_(options.matcher, options.mhd, options.refinement),
      merged_(std::move(first)),
      ends_{merged_.keyframes.size()} {
  merged_.is_finished = true;
  merged_.state.clear();
}

PlaceVotes SessionMerger::Add(const SessionContents& next) {
  PlaceVotes votes = VoteOnPlace(options_, merge_, merged_, next, num_threads_);
  if (!votes.reason.empty()) return votes;
  const IdShift shift(merged_);
  const size_t num_known = merged_.scans.size();
  Append(next, shift, votes.T_a_b, &merged_);
  ends_.push_back(merged_.keyframes.size());
  for (const PlaceVote& vote : votes.agreeing) {
    merged_.graph.AddConstraint(
        {vote.submap, shift(vote.keyframe), vote.match.pose, vote.match.information, Constraint::Kind::kLoop});
  }
  // So well placed, the next session and the search for loops find everything where it is.
  merged_.graph.Optimize(options_.graph, num_threads_);
  LayOnKnownGround(options_.terrain, merged_.graph, num_known, &merged_.scans);
  return votes;
}

MergeSolution SessionMerger::Finish() {
  MergeSolution solution;
  static_cast<GlobalSolution&>(solution) =
      SolveGlobally(options_, matcher_, num_threads_, merged_.keyframes, &merged_.graph, &merged_.submaps);
  SmoothTilts(options_.terrain, merged_.graph, &merged_.scans);
  CountCross(&solution);
  return solution;
}

void SessionMerger::CountCross(MergeSolution* solution) const {
  const auto session_of = [this](KeyframeId id) {
    return std::upper_bound(ends_.begin(), ends_.end(), static_cast<size_t>(id.value)) - ends_.begin();
  };
  // A submap is of one session.
  std::map<int, std::ptrdiff_t> session_of_submap;
  for (const Submap& submap : merged_.submaps)
    session_of_submap[submap.id.value] = session_of(submap.keyframes.front());
  for (const LoopCandidate& loop : solution->loops) {
    if (session_of_submap.at(loop.submap.value) == session_of(loop.keyframe)) continue;
    ++solution->num_cross_tried;
    solution->num_cross_accepted += loop.accepted ? 1 : 0;
  }
}

}  // namespace arborslam
