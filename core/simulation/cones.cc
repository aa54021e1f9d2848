#include "core/simulation/cones.h"

#include <cmath>
#include <utility>
#include <vector>

#include "core/config/validation.h"
#include "core/geometry/angles.h"
#include "core/simulation/plants.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr uint64_t kStream = 1;
constexpr double kHalfLength = 3.0;  // [m], of the rectangle along x.
constexpr double kWidth = 2.0;       // [m], of the rectangle along y.
constexpr double kBorder = 1.25;     // [m], how far cones stand outside the rectangle.
constexpr double kClearance = 0.3;   // [m], from a cone's rim to the path.
constexpr double kConeGap = 0.3;     // [m], between the rims of cones.
constexpr double kTipRadius = 0.02;  // [m].
constexpr int kMaxTries = 10000;

double DistanceTo(const ClosedPath& path, const Eigen::Vector2d& place) {
  double nearest = 1e9;
  for (double distance = 0.0; distance < path.Length(); distance += 0.05) {
    nearest = std::min(nearest, (path.At(distance).translation() - place).norm());
  }
  return nearest;
}

}  // namespace

ConesOptions::ConesOptions() {
  run.map_resolution = 0.01;
  run.map_margin = 1.5;
  run.terrain.undulation = 0.08;
  run.terrain.wavelength = 12.0;
  run.terrain.bumps = 0.005;
  run.terrain.grass_height = 0.05;
  run.terrain.grass_clumps = 0.0;
  run.carrier.motion = "trot";
  run.carrier.speed = 0.3;
  run.carrier.sensor_height = 0.5;
  run.carrier.turn_radius = 0.4;
  run.carrier.wander = 0.04;
  run.carrier.ground_following = 0.6;
}

std::string ConesOptions::Validate() const {
  if (cones < 0 || cones > 40) return Violation("cones", cones, "lie in [0, 40]");
  if (!(cone_height >= 0.25 && cone_height <= 2.0)) return Violation("cone_height", cone_height, "lie in [0.25, 2]");
  if (!(cone_radius >= 0.03 && cone_radius <= 0.3)) return Violation("cone_radius", cone_radius, "lie in [0.03, 0.3]");
  if (background_trees < 0 || background_trees > 1000) {
    return Violation("background_trees", background_trees, "lie in [0, 1000]");
  }
  return run.Validate();
}

Scene MakeCones(const ConesOptions& options) {
  const ClosedPath path(
      {{0.0, 0.0}, {kHalfLength, 0.0}, {kHalfLength, kWidth}, {-kHalfLength, kWidth}, {-kHalfLength, 0.0}},
      options.run.carrier.turn_radius);
  Scene scene{path, {GroundAround(path, options.run), {}, {}, {}}};
  World3& world = scene.world;
  Random random(static_cast<uint64_t>(options.run.seed), kStream);
  struct Base {
    Eigen::Vector2d place;
    double radius;
  };
  std::vector<Base> bases;
  for (int i = 0, tries = 0; i < options.cones && tries < kMaxTries; ++tries) {
    const double x = random.Uniform(-kHalfLength - kBorder, kHalfLength + kBorder);
    const double y = random.Uniform(-kBorder, kWidth + kBorder);
    const double radius = options.cone_radius * random.Uniform(0.75, 1.25);
    const double height = options.cone_height + random.Uniform(-0.2, 0.2);
    bool fits = DistanceTo(path, {x, y}) > radius + kClearance;
    for (const Base& other : bases) {
      fits = fits && (other.place - Eigen::Vector2d(x, y)).norm() > radius + other.radius + kConeGap;
    }
    if (!fits) continue;
    bases.push_back({{x, y}, radius});
    Frustum cone;
    cone.base = {x, y, world.terrain.Height({x, y})};
    cone.length = height;
    cone.base_radius = radius;
    cone.top_radius = kTipRadius;
    world.solids.push_back(cone);
    ++i;
  }

  TreeShape tree;
  tree.trunk_radius = 0.15;
  tree.trunk_height = 3.0;
  tree.crown_base = 2.0;
  tree.crown_top = 6.0;
  tree.crown_radius = 2.0;
  for (int i = 0; i < options.background_trees; ++i) {
    const double bearing = random.Uniform(-kPi, kPi);
    const double distance = random.Uniform(10.0, 20.0);
    PlantTree({distance * std::cos(bearing), 0.5 * kWidth + distance * std::sin(bearing)}, tree, &random, &world);
  }
  SetFence({-14.0, -9.0}, {14.0, -9.0}, 3.0, &random, &world);
  PlantLeafWall({-16.0, 14.0}, {2.0, 15.0}, {0.0, 1.6, 0.8, 4.0, 0.0}, &random, &world);
  return scene;
}

}  // namespace arborslam
