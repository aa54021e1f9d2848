#include "core/simulation/simulated_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/simulation/footprint_map.h"
#include "core/simulation/person.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

// First of the random streams of each kind; the n-th sweep uses the n-th stream after it.
enum Stream : uint64_t {
  kFollowers = 140,
  kOdometry = 141,
  kControls = uint64_t{1} << 32,
  kBeams = 2 * kControls,
};

constexpr double kExtentSampling = 0.25;  // [m] along a path.
constexpr double kNearestFollower = 1.6;  // [m] behind the carrier, mean.
constexpr double kFollowerGap = 0.9;      // [m] between followers, mean.
constexpr double kStride = 0.9;           // [m], two steps of a follower.
constexpr double kSwing = 0.6;            // Of the widest stride.

// People who keep 1 to 3 m behind the carrier and to its sides.
std::function<std::vector<Frustum>(double)> Followers(int count, uint64_t seed, const Carrier* carrier,
                                                      const UnevenGround* terrain) {
  struct Follower {
    double distance, left, height, phase;
  };
  Random random(seed, kFollowers);
  std::vector<Follower> followers;
  for (int i = 0; i < count; ++i) {
    const double left = (i % 2 == 0 ? 1.0 : -1.0) * random.Uniform(0.1, 0.4);
    followers.push_back(
        {kNearestFollower + kFollowerGap * i, left, random.Uniform(1.6, 1.9), random.Uniform(-kPi, kPi)});
  }
  return [followers, carrier, terrain](double time) {
    std::vector<Frustum> solids;
    for (const Follower& follower : followers) {
      const double behind = follower.distance + 0.4 * std::sin(0.23 * time + follower.phase);
      const double walked = carrier->DistanceAt(time) - behind;
      const double left = follower.left + 0.2 * std::sin(0.31 * time + 2.0 * follower.phase);
      const SE2 place = carrier->OnPath(walked) * SE2(0.0, left, 0.0);
      const double swing = kSwing * std::sin(2.0 * kPi * walked / kStride);
      const auto person = PersonAt(place, terrain->SmoothHeight(place.translation()), follower.height, swing);
      solids.insert(solids.end(), person.begin(), person.end());
    }
    return solids;
  };
}

}  // namespace

std::string RunOptions::Validate() const {
  if (seed < 0) return Violation("seed", seed, "be at least 0");
  if (num_scans < 0 || num_scans > 1000000) return Violation("num_scans", num_scans, "lie in [0, 1000000]");
  if (followers < 0 || followers > 10) return Violation("followers", followers, "lie in [0, 10]");
  if (!(map_resolution >= 0.005 && map_resolution <= 1.0)) {
    return Violation("map_resolution", map_resolution, "lie in [0.005, 1]");
  }
  if (!(map_margin >= 0.0 && map_margin <= 100.0)) return Violation("map_margin", map_margin, "lie in [0, 100]");
  for (const std::string& problem : {terrain.Validate(), carrier.Validate(), lidar.Validate()}) {
    if (!problem.empty()) return problem;
  }
  return "";
}

Extent ExtentOf(const ClosedPath& path) {
  Extent extent{path.At(0.0).translation(), path.At(0.0).translation()};
  for (double distance = 0.0; distance < path.Length(); distance += kExtentSampling) {
    const Eigen::Vector2d position = path.At(distance).translation();
    extent.low = extent.low.cwiseMin(position);
    extent.high = extent.high.cwiseMax(position);
  }
  return extent;
}

UnevenGround GroundAround(const ClosedPath& path, const RunOptions& options) {
  const Extent extent = ExtentOf(path);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(options.lidar.max_range + 5.0);
  return UnevenGround(options.terrain, static_cast<uint64_t>(options.seed), extent.low - margin, extent.high + margin);
}

SimulatedRun::SimulatedRun(const RunOptions& options, Scene scene)
    : options_(options),
      scene_(std::move(scene)),
      carrier_(options.carrier, scene_.path, &scene_.world.terrain, static_cast<uint64_t>(options.seed)),
      lidar_(options.lidar, &scene_.world) {
  const double span = std::max(0.0, carrier_.Duration() - options.lidar.sweep_duration);
  const auto once_around = 1 + static_cast<size_t>(std::floor(span / options.lidar.sweep_period));
  num_scans_ = options.num_scans > 0 ? static_cast<size_t>(options.num_scans) : once_around;
  if (options.followers > 0) {
    scene_.world.moving =
        Followers(options.followers, static_cast<uint64_t>(options.seed), &carrier_, &scene_.world.terrain);
  }
}

LidarSweep SimulatedRun::Sweep(size_t index) const {
  Random random(static_cast<uint64_t>(options_.seed), kBeams + index);
  return lidar_.Measure([this](double time) { return carrier_.PoseAt(time); }, Start(index), &random);
}

Trajectory3 SimulatedRun::GroundTruth() const {
  Trajectory3 truth;
  for (size_t i = 0; i < num_scans_; ++i) {
    const Eigen::Isometry3d pose = TruePose(i);
    Eigen::Quaterniond orientation(pose.linear());
    if (orientation.w() < 0.0) orientation.coeffs() *= -1.0;
    truth.poses.push_back({Middle(i), pose.translation(), orientation.normalized()});
  }
  return truth;
}

OdometryVelocity SimulatedRun::Control(size_t index) const {
  Random odometry(static_cast<uint64_t>(options_.seed), kOdometry);
  const double scale = 1.0 + 0.02 * odometry.Gaussian();
  const double yaw_bias = 0.002 * odometry.Gaussian();
  Random random(static_cast<uint64_t>(options_.seed), kControls + index);
  OdometryVelocity velocity = carrier_.VelocityAt(Middle(index));
  velocity.forward += 0.05 * velocity.forward * random.Gaussian() + 0.01 * random.Gaussian();
  velocity.forward *= scale;
  velocity.left += 0.01 * random.Gaussian();
  velocity.yaw += yaw_bias + 0.05 * velocity.yaw * random.Gaussian() + 0.01 * random.Gaussian();
  return velocity;
}

GridImage SimulatedRun::Map() const {
  const Extent extent = ExtentOf(scene_.path);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(options_.map_margin);
  return FootprintMap(scene_.world, extent.low - margin, extent.high + margin, options_.map_resolution);
}

}  // namespace arborslam
