#include "core/simulation/lidar3.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/config/validation.h"
#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMinMargin = 0.02;  // [m], beyond the sensor's way in a sweep.

}  // namespace

std::string Lidar3Options::Validate() const {
  if (rings < 1 || rings > 256) return Violation("rings", rings, "lie in [1, 256]");
  if (!(lowest_beam > -90.0 && lowest_beam < 90.0)) return Violation("lowest_beam", lowest_beam, "lie in (-90, 90)");
  if (!(highest_beam >= lowest_beam && highest_beam < 90.0)) {
    return Violation("highest_beam", highest_beam, "lie in [lowest_beam, 90)");
  }
  if (columns < 4 || columns > 100000) return Violation("columns", columns, "lie in [4, 100000]");
  if (!(std::abs(first_bearing) <= 360.0)) return Violation("first_bearing", first_bearing, "lie in [-360, 360]");
  if (!(sweep_duration >= 0.0 && sweep_duration <= 100.0)) {
    return Violation("sweep_duration", sweep_duration, "lie in [0, 100]");
  }
  if (!(sweep_period > 0.0 && sweep_period >= sweep_duration && sweep_period <= 1000.0)) {
    return Violation("sweep_period", sweep_period, "lie in [sweep_duration, 1000] and be more than 0");
  }
  if (!(min_range >= 0.0)) return Violation("min_range", min_range, "be at least 0");
  if (!(max_range > min_range && max_range <= 1000.0)) {
    return Violation("max_range", max_range, "lie in (min_range, 1000]");
  }
  if (!(range_noise >= 0.0 && range_noise <= 10.0)) return Violation("range_noise", range_noise, "lie in [0, 10]");
  if (!(range_resolution >= 0.0 && range_resolution <= 1.0)) {
    return Violation("range_resolution", range_resolution, "lie in [0, 1]");
  }
  if (!(drop_out >= 0.0 && drop_out <= 1.0)) return Violation("drop_out", drop_out, "lie in [0, 1]");
  return "";
}

Lidar3Options Os1Options() {
  Lidar3Options options;
  options.lowest_beam = -16.6;
  options.highest_beam = 16.6;
  options.columns = 2000;
  options.range_noise = 0.025;
  options.range_resolution = 0.003;
  return options;
}

Lidar3::Lidar3(const Lidar3Options& options, const World3* world) : options_(options), world_(world) {
  for (const Frustum& solid : world->solids) bounds_.push_back(BoundsOf(solid));
  for (const Leaves& leaves : world->leaves) bounds_.push_back(BoundsOf(leaves));
  for (int ring = 0; ring < options.rings; ++ring) {
    const double share = options.rings > 1 ? static_cast<double>(ring) / (options.rings - 1) : 0.0;
    const double elevation = DegToRad(options.lowest_beam + share * (options.highest_beam - options.lowest_beam));
    elevations_.emplace_back(std::cos(elevation), std::sin(elevation));
  }
}

double Lidar3::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const BearingIndex& index,
                    const std::vector<Frustum>& moving, Random* random) const {
  const double farthest = std::min(options_.max_range, world_->terrain.RangeToFloor(origin, direction));
  double nearest = farthest;
  const double level = direction.head<2>().norm();
  const double climb = level > 0.0 ? direction.z() / level : 0.0;
  for (const BearingIndex::Entry& entry : index.Towards(direction.head<2>())) {
    if (entry.near > nearest * level) break;  // So are all that follow.
    const double height_near = origin.z() + climb * entry.near;
    const double height_far = origin.z() + climb * entry.far;
    if (std::max(height_near, height_far) < entry.low || std::min(height_near, height_far) > entry.high) continue;
    if (entry.thing < world_->solids.size()) {
      nearest = std::min(nearest, Intersect(world_->solids[entry.thing], origin, direction));
    } else {
      const Leaves& leaves = world_->leaves[entry.thing - world_->solids.size()];
      const Passage passage = PassageThrough(leaves, origin, direction);
      if (passage.entry >= passage.exit) continue;
      const double range = passage.entry + random->Exponential() / leaves.density;
      if (range < passage.exit) nearest = std::min(nearest, range);
    }
  }
  for (const Frustum& solid : moving) nearest = std::min(nearest, Intersect(solid, origin, direction));
  const double ground = world_->terrain.Cast(origin, direction, nearest, random);
  if (ground <= nearest) return ground;
  return nearest < farthest ? nearest : kInfinity;
}

LidarSweep Lidar3::Measure(const std::function<Eigen::Isometry3d(double)>& pose_at, double start,
                           Random* random) const {
  const double duration = options_.sweep_duration;
  const Eigen::Vector2d place = pose_at(start + 0.5 * duration).translation().head<2>();
  double margin = 0.0;
  constexpr int kProbes = 8;
  for (int i = 0; i <= kProbes; ++i) {
    const Eigen::Isometry3d pose = pose_at(start + duration * i / kProbes);
    margin = std::max(margin, (pose.translation().head<2>() - place).norm());
  }
  const BearingIndex index(bounds_, place, 1.5 * margin + kMinMargin, options_.max_range);

  LidarSweep sweep;
  sweep.start = start;
  sweep.duration = duration;
  const size_t most = static_cast<size_t>(options_.columns) * elevations_.size();
  sweep.points.reserve(most);
  sweep.times.reserve(most);
  std::vector<Frustum> moving_here;
  for (int column = 0; column < options_.columns; ++column) {
    const double share = static_cast<double>(column) / options_.columns;
    const double since_start = share * duration;
    const Eigen::Isometry3d T_world_lidar = pose_at(start + since_start);
    const double bearing = DegToRad(options_.first_bearing) - 2.0 * kPi * share;
    const Eigen::Vector2d heading(std::cos(bearing), std::sin(bearing));
    moving_here.clear();
    if (world_->moving) {
      const Eigen::Vector3d ahead = T_world_lidar.linear() * Eigen::Vector3d(heading.x(), heading.y(), 0.0);
      const Eigen::Vector2d flat = ahead.head<2>().normalized();
      for (const Frustum& solid : world_->moving(start + since_start)) {
        const Bounds bounds = BoundsOf(solid);
        const Eigen::Vector2d offset = bounds.center - T_world_lidar.translation().head<2>();
        // The rings of a tilted sensor stray from the column's plane.
        const double reach = bounds.radius + 0.1 * offset.norm();
        if (std::abs(flat.x() * offset.y() - flat.y() * offset.x()) < reach && flat.dot(offset) > -reach) {
          moving_here.push_back(solid);
        }
      }
    }
    for (const Eigen::Vector2d& elevation : elevations_) {
      const Eigen::Vector3d ray(elevation.x() * heading.x(), elevation.x() * heading.y(), elevation.y());
      const double hit = Cast(T_world_lidar.translation(), T_world_lidar.linear() * ray, index, moving_here, random);
      if (!(hit >= options_.min_range && hit <= options_.max_range)) continue;
      const bool lost = random->Uniform() < options_.drop_out;
      double range = hit + options_.range_noise * random->Gaussian();
      if (options_.range_resolution > 0.0) {
        range = std::round(range / options_.range_resolution) * options_.range_resolution;
      }
      if (lost || !(range > 0.0)) continue;
      sweep.points.emplace_back((range * ray).cast<float>());
      sweep.times.push_back(static_cast<float>(since_start));
    }
  }
  return sweep;
}

}  // namespace arborslam
