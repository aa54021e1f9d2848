#include "core/simulation/forest.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/simulation/plants.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

enum Stream : uint64_t { kPath = 5, kPlants = 6 };

constexpr int kCorners = 20;             // Of the figure of eight.
constexpr double kBorder = 60.0;         // [m] of forest around the path.
constexpr double kTrunkClearance = 0.7;  // [m] from the path to the axis of a tree, least, plus its radius.
constexpr double kBushClearance = 1.2;   // [m].
constexpr size_t kMaxTries = 4;          // For each tree: where they must stand far apart, there are fewer.

ClosedPath FigureOfEight(double length, double turn_radius, Random* random) {
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < kCorners; ++i) {
    const double t = 2.0 * kPi * i / kCorners;
    const double stray = i % (kCorners / 2) == 0 ? 0.0 : 0.12;
    const double dx = stray * random->Uniform(-1.0, 1.0);
    const double dy = stray * random->Uniform(-1.0, 1.0);
    corners.emplace_back(std::sin(t) + dx, 0.6 * std::sin(2.0 * t) + dy);
  }
  // Turned so that the first leg leads along +x, and as large as it must be.
  const double bearing = std::atan2(corners[1].y(), corners[1].x());
  double around = 0.0;
  for (int i = 0; i < kCorners; ++i) around += (corners[(i + 1) % kCorners] - corners[i]).norm();
  for (Eigen::Vector2d& corner : corners) corner = (length / around) * (SE2(0.0, 0.0, -bearing) * corner);
  return ClosedPath(corners, turn_radius);
}

// Points of a path, to tell how near it is.
class PathPoints {
 public:
  explicit PathPoints(const ClosedPath& path) {
    for (double distance = 0.0; distance < path.Length(); distance += 0.2) {
      points_.push_back(path.At(distance).translation());
    }
  }
  bool IsWithin(const Eigen::Vector2d& place, double distance) const {
    return std::any_of(points_.begin(), points_.end(), [&](const Eigen::Vector2d& point) {
      return (point - place).squaredNorm() < distance * distance;
    });
  }

 private:
  std::vector<Eigen::Vector2d> points_;
};

}  // namespace

ForestOptions::ForestOptions() {
  run.terrain.undulation = 0.4;
  run.terrain.wavelength = 25.0;
  run.terrain.bumps = 0.03;
  run.terrain.grass_height = 0.12;
  run.terrain.grass_cover = 0.4;
  run.terrain.grass_clumps = 0.05;
  run.carrier.motion = "handheld";
  run.carrier.speed = 1.0;
  run.carrier.sensor_height = 1.5;
  run.carrier.turn_radius = 3.0;
  run.carrier.wander = 0.3;
  run.carrier.ground_following = 0.0;
}

std::string ForestOptions::Validate() const {
  if (!(path_length >= 20.0 && path_length <= 3000.0)) {
    return Violation("path_length", path_length, "lie in [20, 3000]");
  }
  if (!(stems >= 0.0 && stems <= 5000.0)) return Violation("stems", stems, "lie in [0, 5000]");
  if (!(stem_distance >= 0.0 && stem_distance <= 20.0)) {
    return Violation("stem_distance", stem_distance, "lie in [0, 20]");
  }
  if (!(trunk_radius >= 0.01 && trunk_radius <= 1.0)) {
    return Violation("trunk_radius", trunk_radius, "lie in [0.01, 1]");
  }
  if (!(bushes >= 0.0 && bushes <= 5000.0)) return Violation("bushes", bushes, "lie in [0, 5000]");
  if (!(leaf_density > 0.0 && leaf_density <= 100.0)) {
    return Violation("leaf_density", leaf_density, "lie in (0, 100]");
  }
  return run.Validate();
}

Scene MakeForest(const ForestOptions& options) {
  Random path_random(static_cast<uint64_t>(options.run.seed), kPath);
  const ClosedPath path = FigureOfEight(options.path_length, options.run.carrier.turn_radius, &path_random);
  Scene scene{path, {GroundAround(path, options.run), {}, {}, {}}};
  World3& world = scene.world;
  Random random(static_cast<uint64_t>(options.run.seed), kPlants);
  const PathPoints points(path);
  const Extent extent = ExtentOf(path);
  const Eigen::Vector2d low = extent.low - Eigen::Vector2d::Constant(kBorder);
  const Eigen::Vector2d high = extent.high + Eigen::Vector2d::Constant(kBorder);
  const double hectares = (high - low).prod() / 10000.0;
  const double wander = options.run.carrier.wander;

  std::vector<Eigen::Vector2d> trees;
  const auto wanted = static_cast<size_t>(options.stems * hectares);
  for (size_t tries = 0; trees.size() < wanted && tries < kMaxTries * wanted; ++tries) {
    const Eigen::Vector2d place(random.Uniform(low.x(), high.x()), random.Uniform(low.y(), high.y()));
    TreeShape tree;
    tree.trunk_radius = options.trunk_radius * std::exp(0.4 * std::clamp(random.Gaussian(), -2.0, 2.0));
    const double height = 60.0 * tree.trunk_radius + 7.0;
    tree.trunk_height = 0.9 * height;
    tree.top_share = 0.2;
    tree.lean = 2.5;
    tree.limbs = random.Uniform() < 0.5 ? 2 : 0;
    tree.crown_base = height * random.Uniform(0.3, 0.5);
    tree.crown_top = height;
    tree.crown_radius = 1.0 + 6.0 * tree.trunk_radius;
    tree.crown_parts = 2;
    tree.leaf_density = options.leaf_density;
    if (points.IsWithin(place, kTrunkClearance + wander + 1.25 * tree.trunk_radius)) continue;
    const bool is_crowded = std::any_of(trees.begin(), trees.end(), [&](const Eigen::Vector2d& other) {
      return (other - place).squaredNorm() < options.stem_distance * options.stem_distance;
    });
    if (is_crowded) continue;
    trees.push_back(place);
    PlantTree(place, tree, &random, &world);
  }
  const auto bushes = static_cast<int>(options.bushes * hectares);
  for (int i = 0; i < bushes; ++i) {
    const Eigen::Vector2d place(random.Uniform(low.x(), high.x()), random.Uniform(low.y(), high.y()));
    const double radius = random.Uniform(0.3, 0.8);
    const double height = random.Uniform(0.4, 1.6);
    const double density = random.Uniform(0.8, 2.5);
    if (points.IsWithin(place, kBushClearance + wander)) continue;
    PlantBush(place, radius, height, density, &world);
  }
  return scene;
}

}  // namespace arborslam
