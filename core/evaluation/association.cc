#include "core/evaluation/association.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "core/error.h"

namespace arborslam {
namespace {

constexpr double kMaxCoordinate = 1e9;  // [m]; metre-sized errors vanish in the rounding long before.
constexpr double kMinQuaternionNorm = 1e-6;

std::string FormatSeconds(double seconds) {
  char text[64];
  // Stamps since 1970 need their milliseconds; a double holds no more digits than these.
  std::snprintf(text, sizeof(text), "%.13g", seconds);
  return text;
}

std::vector<StampedPose3> SortedByStamp(const Trajectory3& trajectory, const char* role, const std::string& place) {
  if (trajectory.poses.empty()) {
    throw UserError(place, std::string("the ") + role + " has no poses", "give a trajectory with at least one pose");
  }
  std::vector<StampedPose3> poses = trajectory.poses;
  for (size_t i = 0; i < poses.size(); ++i) {
    const char* problem = nullptr;
    if (!std::isfinite(poses[i].stamp)) problem = "a stamp that is not finite";
    // The comparison is false for NaN, too.
    if (!(poses[i].position.array().abs() <= kMaxCoordinate).all()) {
      problem = "a coordinate that is not finite or beyond 1e9 m";
    }
    const double norm = poses[i].orientation.norm();
    if (!std::isfinite(norm) || norm < kMinQuaternionNorm) problem = "an orientation that is no rotation";
    if (problem != nullptr) {
      throw UserError(place, "pose " + std::to_string(i + 1) + " of the " + role + " has " + problem,
                      "correct or remove the pose");
    }
    poses[i].orientation.normalize();
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const StampedPose3& a, const StampedPose3& b) { return a.stamp < b.stamp; });
  return poses;
}

std::string TimeRange(const std::vector<StampedPose3>& poses) {
  return "from " + FormatSeconds(poses.front().stamp) + " s to " + FormatSeconds(poses.back().stamp) + " s";
}

StampedPose3 Interpolate(const StampedPose3& before, const StampedPose3& after, double stamp) {
  const double t = (stamp - before.stamp) / (after.stamp - before.stamp);
  return {stamp, (1.0 - t) * before.position + t * after.position, before.orientation.slerp(t, after.orientation)};
}

}  // namespace

std::string AssociationOptions::Validate() const {
  if (!std::isfinite(max_time_difference) || max_time_difference < 0.0) {
    return "max_time_difference is " + std::to_string(max_time_difference) + " s but must be 0 or more";
  }
  if (!std::isfinite(max_interpolation_gap) || max_interpolation_gap < 0.0) {
    return "max_interpolation_gap is " + std::to_string(max_interpolation_gap) + " s but must be 0 or more";
  }
  return "";
}

AssociationResult Associate(const Trajectory3& estimate, const Trajectory3& reference,
                            const AssociationOptions& options, const std::string& place) {
  if (const std::string problem = options.Validate(); !problem.empty()) throw std::invalid_argument(problem);
  const std::vector<StampedPose3> estimates = SortedByStamp(estimate, "estimate", place);
  const std::vector<StampedPose3> references = SortedByStamp(reference, "reference", place);

  std::vector<std::optional<StampedPose3>> partner(estimates.size());
  std::vector<bool> used(references.size(), false);
  std::vector<std::optional<size_t>> claimed_by(references.size());
  for (size_t i = 0; i < estimates.size(); ++i) {
    const double stamp = estimates[i].stamp;
    const auto at_or_after =
        std::lower_bound(references.begin(), references.end(), stamp,
                         [](const StampedPose3& pose, double value) { return pose.stamp < value; });
    const size_t after = static_cast<size_t>(at_or_after - references.begin());
    const bool is_between = after > 0 && after < references.size() && references[after].stamp > stamp;
    if (is_between && references[after].stamp - references[after - 1].stamp <= options.max_interpolation_gap) {
      partner[i] = Interpolate(references[after - 1], references[after], stamp);
      used[after - 1] = used[after] = true;
      continue;
    }
    size_t nearest = after;
    if (after == references.size() ||
        (after > 0 && stamp - references[after - 1].stamp <= references[after].stamp - stamp)) {
      nearest = after - 1;
    }
    const double difference = std::abs(references[nearest].stamp - stamp);
    if (difference > options.max_time_difference) continue;
    std::optional<size_t>& owner = claimed_by[nearest];
    if (owner && std::abs(references[nearest].stamp - estimates[*owner].stamp) <= difference) continue;
    if (owner) partner[*owner].reset();
    owner = i;
    partner[i] = references[nearest];
    used[nearest] = true;
  }

  AssociationResult result;
  result.has_headings = estimate.has_orientation && reference.has_orientation;
  for (size_t i = 0; i < estimates.size(); ++i) {
    if (partner[i]) result.pairs.push_back({estimates[i], *partner[i]});
  }
  result.unmatched_estimate = estimates.size() - result.pairs.size();
  result.unmatched_reference = static_cast<size_t>(std::count(used.begin(), used.end(), false));
  if (result.pairs.empty()) {
    throw UserError(place,
                    "no stamps match within " + FormatSeconds(options.max_time_difference) + " s: the estimate runs " +
                        TimeRange(estimates) + ", the reference " + TimeRange(references),
                    "check that both use the same clock, or allow a larger time difference");
  }
  return result;
}

}  // namespace arborslam
