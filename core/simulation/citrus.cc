#include "core/simulation/citrus.h"

#include <vector>

#include "core/config/validation.h"
#include "core/simulation/plants.h"
#include "core/simulation/random.h"
#include "core/simulation/row_path.h"

namespace arborslam {
namespace {

constexpr uint64_t kStream = 2;
constexpr double kPositionJitter = 0.2;  // [m].

// Every lane once and, on the way back, two of three once more.
std::vector<int> Lanes(int rows) {
  std::vector<int> lanes;
  for (int lane = 0; lane <= rows; ++lane) lanes.push_back(lane);
  for (int lane = rows - 1; lane > 0; --lane) {
    if ((rows - lane) % 3 != 1) lanes.push_back(lane);
  }
  if (lanes.size() % 2 != 0) lanes.pop_back();
  return lanes;
}

}  // namespace

CitrusOptions::CitrusOptions() {
  run.terrain.undulation = 0.3;
  run.terrain.wavelength = 35.0;
  run.terrain.grass_height = 0.08;
  run.terrain.grass_cover = 0.4;
  run.carrier.motion = "wheeled";
  run.carrier.speed = 1.0;
  run.carrier.sensor_height = 0.7;
  run.carrier.turn_radius = 2.0;
}

std::string CitrusOptions::Validate() const {
  if (rows < 1 || rows > 100) return Violation("rows", rows, "lie in [1, 100]");
  if (!(row_spacing >= 3.0 && row_spacing <= 50.0)) return Violation("row_spacing", row_spacing, "lie in [3, 50]");
  if (!(row_length >= 1.0 && row_length <= 1000.0)) return Violation("row_length", row_length, "lie in [1, 1000]");
  if (!(tree_spacing >= 0.5 && tree_spacing <= 50.0)) {
    return Violation("tree_spacing", tree_spacing, "lie in [0.5, 50]");
  }
  if (!(missing_trees >= 0.0 && missing_trees <= 1.0)) {
    return Violation("missing_trees", missing_trees, "lie in [0, 1]");
  }
  if (!(leaf_density > 0.0 && leaf_density <= 100.0)) {
    return Violation("leaf_density", leaf_density, "lie in (0, 100]");
  }
  if (!(headland >= 1.0 && headland <= 100.0)) return Violation("headland", headland, "lie in [1, 100]");
  return run.Validate();
}

Scene MakeCitrus(const CitrusOptions& options) {
  const ClosedPath path = RowPath(Lanes(options.rows), options.row_spacing, -options.headland,
                                  options.row_length + options.headland, options.run.carrier.turn_radius);
  Scene scene{path, {GroundAround(path, options.run), {}, {}, {}}};
  Random random(static_cast<uint64_t>(options.run.seed), kStream);
  TreeShape tree;
  tree.trunk_radius = 0.11;
  tree.trunk_height = 1.6;
  tree.limbs = 4;
  tree.crown_base = 0.4;
  tree.crown_top = 3.6;
  tree.crown_radius = 1.6;
  tree.crown_parts = 4;
  tree.leaf_density = options.leaf_density;
  const int trees = 1 + static_cast<int>(options.row_length / options.tree_spacing);
  for (int row = 0; row < options.rows; ++row) {
    for (int i = 0; i < trees; ++i) {
      const double x = i * options.tree_spacing + random.Uniform(-kPositionJitter, kPositionJitter);
      const double y = (row + 0.5) * options.row_spacing + random.Uniform(-kPositionJitter, kPositionJitter);
      if (random.Uniform() < options.missing_trees) continue;
      PlantTree({x, y}, tree, &random, &scene.world);
    }
  }
  const double border = options.headland + 6.0;
  const Eigen::Vector2d low(-border, -border);
  const Eigen::Vector2d high(options.row_length + border, options.rows * options.row_spacing + border);
  SetFence(low, {high.x(), low.y()}, 4.0, &random, &scene.world);
  SetFence({low.x(), high.y()}, high, 4.0, &random, &scene.world);
  return scene;
}

}  // namespace arborslam
