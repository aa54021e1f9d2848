#ifndef ARBORSLAM_TESTS_BACKEND_GRID_ORCHARD_H_
#define ARBORSLAM_TESTS_BACKEND_GRID_ORCHARD_H_

#include <cmath>
#include <cstdint>

#include "core/geometry/se2.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"

namespace arborslam {

/// Equal trees on an exact grid.
inline PlanarOrchardOptions GridOrchardOptions(int seed) {
  PlanarOrchardOptions world = IdealPlanarOrchardOptions();
  world.seed = seed;
  world.rows = 5;
  world.trees_per_row = 21;
  return world;
}

/// 5 m in a random direction: one to two trees or a row.
inline SE2 DriftInAGrid(int seed) {
  Random random(static_cast<uint64_t>(seed));
  const double direction = random.Uniform(-3.0, 3.0);
  return {5.0 * std::cos(direction), 5.0 * std::sin(direction), 0.0};
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BACKEND_GRID_ORCHARD_H_
