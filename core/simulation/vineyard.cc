#include "core/simulation/vineyard.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/config/validation.h"
#include "core/simulation/plants.h"
#include "core/simulation/random.h"
#include "core/simulation/row_path.h"

namespace arborslam {
namespace {

constexpr uint64_t kStream = 3;
constexpr double kVineRadius = 0.03;  // [m].
constexpr double kHeadHeight = 0.8;   // [m], where a vine's trunk ends.
constexpr double kPostRadius = 0.04;  // [m].
constexpr double kPostHeight = 1.9;   // [m].

// A thin trunk with a knee.
void PlantVine(const Eigen::Vector2d& place, Random* random, World3* world) {
  const double radius = kVineRadius * random->Uniform(0.7, 1.3);
  const auto shift = [&] { return Eigen::Vector2d(0.05 * random->Gaussian(), 0.03 * random->Gaussian()); };
  const double ground = world->terrain.Height(place);
  const Eigen::Vector2d knee = place + shift();
  const Eigen::Vector2d head = knee + shift();
  const Eigen::Vector3d low(place.x(), place.y(), ground - 0.2);
  const Eigen::Vector3d middle(knee.x(), knee.y(), ground + 0.5 * kHeadHeight);
  const Eigen::Vector3d high(head.x(), head.y(), ground + kHeadHeight * random->Uniform(0.9, 1.1));
  world->solids.push_back(Frustum::Between(low, middle, 1.2 * radius, radius));
  world->solids.push_back(Frustum::Between(middle, high, radius, 1.1 * radius));
}

}  // namespace

VineyardOptions::VineyardOptions() {
  run.terrain.undulation = 0.3;
  run.terrain.wavelength = 40.0;
  run.terrain.grass_height = 0.12;
  run.terrain.grass_cover = 0.5;
  run.carrier.motion = "wheeled";
  run.carrier.speed = 0.8;
  run.carrier.sensor_height = 0.9;
  run.carrier.turn_radius = 1.2;
  run.carrier.wander = 0.1;
  run.lidar = Os1Options();
}

std::string VineyardOptions::Validate() const {
  if (corridors < 2 || corridors > 100) return Violation("corridors", corridors, "lie in [2, 100]");
  const std::pair<const char*, double> lengths[] = {{"row_spacing", row_spacing},
                                                    {"row_length", row_length},
                                                    {"post_spacing", post_spacing},
                                                    {"vine_spacing", vine_spacing},
                                                    {"headland", headland}};
  for (const auto& [key, value] : lengths) {
    if (!(value >= 0.2 && value <= 1000.0)) return Violation(key, value, "lie in [0.2, 1000]");
  }
  if (!(row_spacing >= 1.5)) return Violation("row_spacing", row_spacing, "leave room for the robot, at least 1.5");
  if (!(leaf_density > 0.0 && leaf_density <= 100.0)) {
    return Violation("leaf_density", leaf_density, "lie in (0, 100]");
  }
  if (!(leaf_gaps >= 0.0 && leaf_gaps <= 1.0)) return Violation("leaf_gaps", leaf_gaps, "lie in [0, 1]");
  if (background_trees < 0 || background_trees > 1000) {
    return Violation("background_trees", background_trees, "lie in [0, 1000]");
  }
  return run.Validate();
}

Scene MakeVineyard(const VineyardOptions& options) {
  // The robot's first corridor is the second of all where there are as many as three; it skips one on its way.
  const int skipped = options.corridors >= 4 ? 2 : 1;
  const ClosedPath path = RowPath({0, skipped}, options.row_spacing, -options.headland,
                                  options.row_length + options.headland, options.run.carrier.turn_radius);
  Scene scene{path, {GroundAround(path, options.run), {}, {}, {}}};
  World3& world = scene.world;
  Random random(static_cast<uint64_t>(options.run.seed), kStream);
  const int first_corridor = options.corridors >= 3 ? -1 : 0;
  LeafWallShape wall;
  wall.leaf_density = options.leaf_density;
  wall.gaps = options.leaf_gaps;
  for (int row = 0; row <= options.corridors; ++row) {
    const double y = (first_corridor + row - 0.5) * options.row_spacing;
    const double begin = random.Uniform(-0.5, 0.5);
    const double end = options.row_length + random.Uniform(-0.5, 0.5);
    const int posts = std::max(1, static_cast<int>(std::round((end - begin) / options.post_spacing)));
    for (int i = 0; i <= posts; ++i) {
      const double x = begin + (end - begin) * i / posts + random.Uniform(-0.1, 0.1);
      const bool is_end = i == 0 || i == posts;
      SetPost({x, y + 0.03 * random.Gaussian()}, is_end ? 1.5 * kPostRadius : kPostRadius, kPostHeight,
              is_end ? 5.0 : 1.0, &random, &world);
    }
    for (double x = begin + 0.5 * options.vine_spacing; x < end; x += options.vine_spacing) {
      const double along = 0.1 * random.Gaussian();
      const double across = 0.03 * random.Gaussian();
      if (random.Uniform() < 0.05) continue;
      PlantVine({x + along, y + across}, &random, &world);
    }
    PlantLeafWall({begin, y}, {end, y}, wall, &random, &world);
  }
  TreeShape tree;
  tree.trunk_radius = 0.2;
  tree.trunk_height = 3.0;
  tree.crown_base = 2.0;
  tree.crown_top = 7.0;
  tree.crown_radius = 2.5;
  const double width = options.corridors * options.row_spacing;
  for (int i = 0; i < options.background_trees; ++i) {
    // Alternately beyond one of the four sides.
    const double along = random.Uniform();
    const double away = random.Uniform(8.0, 25.0);
    const double x = i % 2 == 0 ? along * options.row_length : (i % 4 == 1 ? -away : options.row_length + away);
    const double y = i % 2 == 1 ? along * width : (i % 4 == 0 ? -away - width / 4.0 : width + away);
    PlantTree({x, y}, tree, &random, &world);
  }
  return scene;
}

}  // namespace arborslam
