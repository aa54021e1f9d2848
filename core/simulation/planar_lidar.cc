#include "core/simulation/planar_lidar.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/config/validation.h"
#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

std::string PlanarLidarOptions::Validate() const {
  if (beams < 3 || beams > 100000) return Violation("beams", beams, "lie in [3, 100000]");
  if (!(min_range >= 0.0)) return Violation("min_range", min_range, "be at least 0");
  if (!(max_range > min_range && max_range <= 1000.0)) {
    return Violation("max_range", max_range, "lie in (min_range, 1000]");
  }
  if (!(range_noise >= 0.0 && range_noise <= 10.0)) return Violation("range_noise", range_noise, "lie in [0, 10]");
  if (!(range_resolution >= 0.0 && range_resolution <= 1.0)) {
    return Violation("range_resolution", range_resolution, "lie in [0, 1]");
  }
  if (!(drop_out >= 0.0 && drop_out <= 1.0)) return Violation("drop_out", drop_out, "lie in [0, 1]");
  if (!(sensor_height > 0.0 && sensor_height <= 10.0)) {
    return Violation("sensor_height", sensor_height, "lie in (0, 10]");
  }
  if (!(ground_roughness >= 0.0 && ground_roughness <= 1.0)) {
    return Violation("ground_roughness", ground_roughness, "lie in [0, 1]");
  }
  return "";
}

PlanarLidar::PlanarLidar(const PlanarLidarOptions& options)
    : options_(options), bearing_increment_(2.0 * kPi / (options.beams + 1)) {
  directions_.reserve(options.beams);
  for (int beam = 0; beam < options.beams; ++beam) {
    const double bearing = -kPi + bearing_increment_ * beam;
    directions_.emplace_back(std::cos(bearing), std::sin(bearing));
  }
}

LaserScan PlanarLidar::Measure(const PlanarWorld& world, const SE2& T_world_lidar, double stamp, const Tilt& tilt,
                               Random* random) const {
  const SE2 T_lidar_world = T_world_lidar.Inverse();
  std::vector<double> ranges(directions_.size(), kInfinity);
  for (const Disc& disc : world.discs) HitDisc(T_lidar_world * disc.center, disc.radius, &ranges);
  for (const Wall& wall : world.walls) HitWall(wall, T_lidar_world, random, &ranges);
  for (const Foliage& foliage : world.foliage) HitFoliage(foliage, T_lidar_world * foliage.center, random, &ranges);
  if (tilt.angle > 0.0) HitGround(tilt, random, &ranges);

  LaserScan scan;
  scan.stamp = stamp;
  scan.bearing_min = -kPi;
  scan.bearing_increment = bearing_increment_;
  scan.ranges.reserve(ranges.size());
  for (const double true_range : ranges) {
    // Drawn for every beam, with or without a return: a beam's noise must not depend on what its neighbours see.
    const bool lost = random->Uniform() < options_.drop_out;
    double range = true_range + options_.range_noise * random->Gaussian();
    if (options_.range_resolution > 0.0) {
      range = std::round(range / options_.range_resolution) * options_.range_resolution;
    }
    const bool visible = true_range >= options_.min_range && true_range <= options_.max_range && range > 0.0;
    scan.ranges.push_back(visible && !lost ? static_cast<float>(range) : std::numeric_limits<float>::infinity());
  }
  return scan;
}

template <class Visit>
void PlanarLidar::VisitBeams(double bearing, double half_width, Visit&& visit) const {
  const int num_beams = static_cast<int>(directions_.size());
  if (half_width >= kPi) {
    for (int beam = 0; beam < num_beams; ++beam) visit(beam);
    return;
  }
  // The full circle has one slot more than there are beams.
  const int num_slots = num_beams + 1;
  const double center = (bearing + kPi) / bearing_increment_;
  const double half_slots = half_width / bearing_increment_;
  const int first = static_cast<int>(std::ceil(center - half_slots));
  const int last = static_cast<int>(std::floor(center + half_slots));
  for (int slot = first; slot <= last; ++slot) {
    const int beam = ((slot % num_slots) + num_slots) % num_slots;
    if (beam < num_beams) visit(beam);
  }
}

void PlanarLidar::HitDisc(const Eigen::Vector2d& center, double radius, std::vector<double>* ranges) const {
  const double distance = center.norm();
  if (distance - radius > options_.max_range) return;
  const double half_width = distance > radius ? std::asin(radius / distance) : kPi;
  VisitBeams(std::atan2(center.y(), center.x()), half_width, [&](int beam) {
    const double along = directions_[beam].dot(center);
    const double across = Cross(directions_[beam], center);
    const double half_chord = std::sqrt(std::max(0.0, radius * radius - across * across));
    const double range = along > half_chord ? along - half_chord : along + half_chord;
    (*ranges)[beam] = std::min((*ranges)[beam], range);
  });
}

void PlanarLidar::HitFoliage(const Foliage& foliage, const Eigen::Vector2d& center, Random* random,
                             std::vector<double>* ranges) const {
  const double distance = center.norm();
  if (distance - foliage.radius > options_.max_range || foliage.density <= 0.0) return;
  const double half_width = distance > foliage.radius ? std::asin(foliage.radius / distance) : kPi;
  VisitBeams(std::atan2(center.y(), center.x()), half_width, [&](int beam) {
    const double along = directions_[beam].dot(center);
    const double across = Cross(directions_[beam], center);
    const double half_chord = std::sqrt(std::max(0.0, foliage.radius * foliage.radius - across * across));
    const double entry = std::max(0.0, along - half_chord);
    const double range = entry + random->Exponential() / foliage.density;
    if (range < along + half_chord) (*ranges)[beam] = std::min((*ranges)[beam], range);
  });
}

void PlanarLidar::HitWall(const Wall& wall, const SE2& T_lidar_world, Random* random,
                          std::vector<double>* ranges) const {
  const Eigen::Vector2d begin = T_lidar_world * wall.begin;
  const Eigen::Vector2d extent = T_lidar_world * wall.end - begin;
  for (size_t beam = 0; beam < ranges->size(); ++beam) {
    // Solves range * direction = begin + fraction * extent.
    const double determinant = Cross(directions_[beam], extent);
    if (determinant == 0.0) continue;
    const double range = Cross(begin, extent) / determinant;
    const double fraction = Cross(begin, directions_[beam]) / determinant;
    if (!(range > 0.0 && range <= options_.max_range && fraction >= 0.0 && fraction <= 1.0)) continue;
    const double depth = wall.roughness > 0.0 ? wall.roughness * random->Exponential() : 0.0;
    (*ranges)[beam] = std::min((*ranges)[beam], range + depth);
  }
}

void PlanarLidar::HitGround(const Tilt& tilt, Random* random, std::vector<double>* ranges) const {
  const double distance = options_.sensor_height / std::tan(tilt.angle);
  const Eigen::Vector2d steepest(std::cos(tilt.direction), std::sin(tilt.direction));
  for (size_t beam = 0; beam < ranges->size(); ++beam) {
    const double cosine = directions_[beam].dot(steepest);
    const double bump = options_.ground_roughness * random->Gaussian();
    if (cosine * options_.max_range < distance) continue;
    (*ranges)[beam] = std::min((*ranges)[beam], std::max(0.0, distance / cosine + bump));
  }
}

}  // namespace arborslam
