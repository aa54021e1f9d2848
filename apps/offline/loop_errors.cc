#include "apps/offline/loop_errors.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/geometry/angles.h"
#include "core/geometry/se2.h"
#include "core/sensor/trajectory3.h"

namespace arborslam {
namespace {

double ShareOf(size_t part, size_t whole) {
  return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
}

// T_reference_base of the keyframes that the reference knows.
std::map<KeyframeId, SE2> TruePoses(const std::vector<PosedScan>& scans, const std::vector<PosePair>& pairs) {
  Trajectory3 references;
  for (const PosePair& pair : pairs) {
    references.poses.push_back(pair.reference);
    references.poses.back().stamp = pair.estimate.stamp;
  }
  std::map<double, SE2> by_stamp;
  for (const StampedPose& reference : ToPlanar(references)) by_stamp[reference.stamp] = reference.pose;
  std::map<KeyframeId, SE2> poses;
  KeyframeId last;
  for (const PosedScan& scan : scans) {
    // The first scan that hangs on a keyframe is the keyframe itself.
    if (scan.keyframe == last) continue;
    last = scan.keyframe;
    const auto found = by_stamp.find(scan.stamp);
    if (found != by_stamp.end()) poses[scan.keyframe] = found->second;
  }
  return poses;
}

// A keyframe that a submap is made of.
struct Member {
  SE2 T_submap_base;
  SE2 T_reference_base;
};

}  // namespace

double LoopErrors::Precision() const { return ShareOf(num_accepted - num_false, num_accepted); }

double LoopErrors::Recall() const { return ShareOf(num_accepted - num_false, num_tried); }

LoopErrors EvaluateLoops(const std::vector<LoopCandidate>& loops, const std::vector<Submap>& submaps,
                         const std::vector<PosedScan>& scans, const PoseGraph& graph,
                         const std::vector<PosePair>& pairs) {
  const std::map<KeyframeId, SE2> truth = TruePoses(scans, pairs);
  std::map<SubmapId, std::vector<Member>> members;
  for (const Submap& submap : submaps) {
    const SE2 T_submap_map = graph.Pose(submap.id).Inverse();
    for (const KeyframeId id : submap.keyframes) {
      const auto found = truth.find(id);
      if (found == truth.end()) continue;
      members[submap.id].push_back({T_submap_map * graph.Pose(id), found->second});
    }
  }
  LoopErrors errors;
  double sum = 0.0;
  for (const LoopCandidate& loop : loops) {
    const auto submap = members.find(loop.submap);
    const auto keyframe = truth.find(loop.keyframe);
    if (submap == members.end() || keyframe == truth.end()) continue;
    ++errors.num_tried;
    if (!loop.accepted) continue;
    ++errors.num_accepted;
    const auto distance = [&loop](const Member& member) {
      return (member.T_submap_base.translation() - loop.match.pose.translation()).squaredNorm();
    };
    const Member& nearest =
        *std::min_element(submap->second.begin(), submap->second.end(),
                          [&](const Member& a, const Member& b) { return distance(a) < distance(b); });
    const SE2 expected = nearest.T_reference_base.Inverse() * keyframe->second;
    const SE2 error = expected.Inverse() * (nearest.T_submap_base.Inverse() * loop.match.pose);
    const double translation = error.translation().norm();
    const bool is_false =
        translation > LoopErrors::kMaxTranslation || std::abs(NormalizeAngle(error.theta())) > LoopErrors::kMaxRotation;
    errors.num_false += is_false ? 1 : 0;
    errors.translation_max = std::max(errors.translation_max, translation);
    sum += translation * translation;
  }
  if (errors.num_accepted > 0) errors.translation_rms = std::sqrt(sum / static_cast<double>(errors.num_accepted));
  return errors;
}

}  // namespace arborslam
