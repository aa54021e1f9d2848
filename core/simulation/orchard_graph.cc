#include "core/simulation/orchard_graph.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

// [1/m^2, 1/rad^2], of a submap's place in the keyframe that begins it.
constexpr double kAnchorInformation = 1e8;

// The pose after `way` [m]: rows along x at y = 0, spacing, 2 * spacing..., with straight ways between their ends.
SE2 PoseAlong(double way, const OrchardGraphOptions& options) {
  const double period = options.row_length + options.row_spacing;
  const double row = std::floor(way / period);
  const double along = way - row * period;
  const bool is_forth = std::fmod(row, 2.0) == 0.0;
  const double y = row * options.row_spacing;
  if (along <= options.row_length) {
    return is_forth ? SE2(along, y, 0.0) : SE2(options.row_length - along, y, kPi);
  }
  return SE2(is_forth ? options.row_length : 0.0, y + along - options.row_length, 0.5 * kPi);
}

class Measurer {
 public:
  Measurer(const std::vector<SE2>& truth, Random* random) : truth_(truth), random_(random) {}

  PoseGraph2::Edge Measure(int from, int to, double translation, double rotation) {
    const double x = translation * random_->Gaussian();
    const double y = translation * random_->Gaussian();
    const SE2 error(x, y, rotation * random_->Gaussian());
    const double shift = 1.0 / (translation * translation);
    const double turn = 1.0 / (rotation * rotation);
    const SE2 T_from_to = truth_[static_cast<size_t>(from)].Inverse() * truth_[static_cast<size_t>(to)];
    return {from, to, T_from_to * error, Eigen::Vector3d(shift, shift, turn).asDiagonal()};
  }

 private:
  const std::vector<SE2>& truth_;
  Random* random_;
};

}  // namespace

std::string OrchardGraphOptions::Validate() const {
  if (num_keyframes < 2 || num_keyframes > 10000000) {
    return Violation("num_keyframes", num_keyframes, "lie in [2, 10000000]");
  }
  if (!(row_length > 0.0)) return Violation("row_length", row_length, "be above 0 m");
  if (!(row_spacing > 0.0)) return Violation("row_spacing", row_spacing, "be above 0 m");
  if (!(step > 0.0)) return Violation("step", step, "be above 0 m");
  if (submap_interval < 2) return Violation("submap_interval", submap_interval, "be at least 2");
  if (loop_stride < 1) return Violation("loop_stride", loop_stride, "be at least 1");
  if (!(loop_reach >= 0.0)) return Violation("loop_reach", loop_reach, "be at least 0 m");
  if (!(motion_translation > 0.0)) return Violation("motion_translation", motion_translation, "be above 0 m");
  if (!(motion_rotation > 0.0)) return Violation("motion_rotation", motion_rotation, "be above 0 rad");
  if (!(match_translation > 0.0)) return Violation("match_translation", match_translation, "be above 0 m");
  if (!(match_rotation > 0.0)) return Violation("match_rotation", match_rotation, "be above 0 rad");
  if (!(loop_translation > 0.0)) return Violation("loop_translation", loop_translation, "be above 0 m");
  if (!(loop_rotation > 0.0)) return Violation("loop_rotation", loop_rotation, "be above 0 rad");
  return "";
}

OrchardGraph SimulateOrchardGraph(const OrchardGraphOptions& options) {
  CHECK_EQ(options.Validate(), "");
  const int num_keyframes = options.num_keyframes;
  const int num_submaps = (num_keyframes + options.submap_interval - 1) / options.submap_interval;
  const auto begin_of = [&options](int submap) { return submap * options.submap_interval; };
  OrchardGraph run;
  run.num_keyframes = static_cast<size_t>(num_keyframes);
  for (int k = 0; k < num_keyframes; ++k) run.truth.push_back(PoseAlong(k * options.step, options));
  for (int s = 0; s < num_submaps; ++s) run.truth.push_back(run.truth[static_cast<size_t>(begin_of(s))]);

  Random random(static_cast<uint64_t>(options.seed));
  Measurer measurer(run.truth, &random);
  std::vector<PoseGraph2::Edge>& edges = run.graph.edges;
  std::vector<SE2> estimate(run.truth.size());
  for (int k = 0; k < num_keyframes; ++k) {
    const int newest = k / options.submap_interval;
    SE2& pose = estimate[static_cast<size_t>(k)];
    if (k > 0) edges.push_back(measurer.Measure(k - 1, k, options.motion_translation, options.motion_rotation));
    for (int s = std::max(0, newest - 1); s <= newest; ++s) {
      const int submap = num_keyframes + s;
      if (begin_of(s) == k) {
        edges.push_back({submap, k, SE2(), kAnchorInformation * Eigen::Matrix3d::Identity()});
        estimate[static_cast<size_t>(submap)] = pose;
        continue;
      }
      edges.push_back(measurer.Measure(submap, k, options.match_translation, options.match_rotation));
      // The older of the two says where the keyframe lies.
      if (s == newest && newest > 0) continue;
      pose = estimate[static_cast<size_t>(submap)] * edges.back().measurement;
    }
  }
  run.first_loop = edges.size();

  // The submaps of the row before, driven the other way, lie as far back as it is to the row's end, twice.
  const double period = options.row_length + options.row_spacing;
  for (int k = 0; k < num_keyframes; k += options.loop_stride) {
    const double row = std::floor(k * options.step / period);
    if (row < 1.0) continue;
    const int first = static_cast<int>((row - 1.0) * period / options.step) / options.submap_interval;
    const int last = static_cast<int>(row * period / options.step) / options.submap_interval;
    for (int s = first; s <= last; ++s) {
      if (k - begin_of(s) < 2 * options.submap_interval) break;
      const SE2& place = run.truth[static_cast<size_t>(num_keyframes + s)];
      if ((place.translation() - run.truth[static_cast<size_t>(k)].translation()).norm() > options.loop_reach) continue;
      edges.push_back(measurer.Measure(num_keyframes + s, k, options.loop_translation, options.loop_rotation));
    }
  }
  for (size_t i = 0; i < estimate.size(); ++i) run.graph.vertices.emplace(static_cast<int>(i), estimate[i]);
  return run;
}

}  // namespace arborslam
