#include "core/simulation/orchard.h"

#include <utility>
#include <vector>

#include "core/config/validation.h"
#include "core/simulation/plants.h"
#include "core/simulation/random.h"
#include "core/simulation/row_path.h"

namespace arborslam {
namespace {

constexpr uint64_t kStream = 4;
constexpr double kPositionJitter = 0.15;  // [m].
constexpr int kLanes = 4;                 // Walked.
constexpr double kBorder = 4.0;           // [m] from the path to the fence.

struct Kind {
  double spacing;  // Over the mean.
  TreeShape shape;
};

// Bushy young trees, old ones with wide crowns, and tall ones with bare trunks.
std::vector<Kind> Kinds(double leaf_density) {
  TreeShape bushy;
  bushy.trunk_radius = 0.06;
  bushy.trunk_height = 1.3;
  bushy.crown_base = 0.55;
  bushy.crown_top = 2.4;
  bushy.crown_radius = 0.85;
  bushy.leaf_density = 1.3 * leaf_density;
  TreeShape wide;
  wide.trunk_radius = 0.11;
  wide.trunk_height = 1.8;
  wide.limbs = 4;
  wide.crown_base = 1.1;
  wide.crown_top = 3.8;
  wide.crown_radius = 1.6;
  wide.crown_parts = 4;
  wide.leaf_density = leaf_density;
  TreeShape tall;
  tall.trunk_radius = 0.09;
  tall.trunk_height = 3.0;
  tall.crown_base = 1.7;
  tall.crown_top = 5.0;
  tall.crown_radius = 1.3;
  tall.leaf_density = 0.8 * leaf_density;
  return {{0.85, bushy}, {1.5, wide}, {1.0, tall}};
}

}  // namespace

OrchardOptions::OrchardOptions() {
  run.followers = 2;
  run.terrain.undulation = 0.35;
  run.terrain.wavelength = 25.0;
  run.terrain.bumps = 0.015;
  run.terrain.grass_height = 0.1;
  run.terrain.grass_cover = 0.7;
  run.carrier.motion = "trot";
  run.carrier.speed = 0.3;
  run.carrier.sensor_height = 0.5;
  run.carrier.turn_radius = 0.6;
  run.carrier.ground_following = 0.6;
  run.lidar.columns = 900;
  run.lidar.sweep_duration = 0.05;
  run.lidar.sweep_period = 0.25;
}

std::string OrchardOptions::Validate() const {
  if (rows < 2 || rows > 100) return Violation("rows", rows, "lie in [2, 100]");
  const std::pair<const char*, double> lengths[] = {
      {"row_length", row_length}, {"tree_spacing", tree_spacing}, {"headland", headland}};
  for (const auto& [key, value] : lengths) {
    if (!(value >= 0.5 && value <= 1000.0)) return Violation(key, value, "lie in [0.5, 1000]");
  }
  if (!(row_spacing >= 2.0 && row_spacing <= 50.0)) return Violation("row_spacing", row_spacing, "lie in [2, 50]");
  if (!(missing_trees >= 0.0 && missing_trees <= 1.0)) {
    return Violation("missing_trees", missing_trees, "lie in [0, 1]");
  }
  if (!(leaf_density > 0.0 && leaf_density <= 100.0)) {
    return Violation("leaf_density", leaf_density, "lie in (0, 100]");
  }
  return run.Validate();
}

Scene MakeOrchard(const OrchardOptions& options) {
  std::vector<int> lanes;
  for (int lane = 0; lane < kLanes; ++lane) lanes.push_back(lane);
  const ClosedPath path = RowPath(lanes, options.row_spacing, -options.headland, options.row_length + options.headland,
                                  options.run.carrier.turn_radius);
  Scene scene{path, {GroundAround(path, options.run), {}, {}, {}}};
  World3& world = scene.world;
  Random random(static_cast<uint64_t>(options.run.seed), kStream);
  const std::vector<Kind> kinds = Kinds(options.leaf_density);
  for (int row = 0; row < options.rows; ++row) {
    // The robot's lanes lie between the second rows on either side where there are as many.
    const double y = (row - 1.5) * options.row_spacing;
    const Kind& kind = kinds[static_cast<size_t>(random.Uniform() * static_cast<double>(kinds.size()))];
    const double spacing = kind.spacing * options.tree_spacing;
    for (double x = 0.5 * spacing; x < options.row_length; x += spacing) {
      const double dx = random.Uniform(-kPositionJitter, kPositionJitter);
      const double dy = random.Uniform(-kPositionJitter, kPositionJitter);
      if (random.Uniform() < options.missing_trees) continue;
      PlantTree({x + dx, y + dy}, kind.shape, &random, &world);
    }
  }
  const Eigen::Vector2d low(-options.headland - kBorder, -2.0 * options.row_spacing - kBorder);
  const Eigen::Vector2d high(options.row_length + options.headland + kBorder,
                             (options.rows - 2.0) * options.row_spacing + kBorder);
  SetFence(low, {high.x(), low.y()}, 3.0, &random, &world);
  SetFence({high.x(), low.y()}, high, 3.0, &random, &world);
  SetFence({low.x(), high.y()}, low, 3.0, &random, &world);
  if (options.hedge) PlantLeafWall(high, {low.x(), high.y()}, {0.0, 1.8, 0.8, 4.0, 0.0}, &random, &world);
  return scene;
}

}  // namespace arborslam
