#include "core/simulation/planar_corridor.h"

#include "core/config/validation.h"
#include "core/simulation/random.h"

namespace arborslam {

std::string PlanarCorridorOptions::Validate() const {
  if (seed < 0) return Violation("seed", seed, "be at least 0");
  if (!(width > 0.0 && width <= 1000.0)) return Violation("width", width, "lie in (0, 1000]");
  if (!(roughness >= 0.0 && roughness <= 10.0)) return Violation("roughness", roughness, "lie in [0, 10]");
  if (num_scans < 1) return Violation("num_scans", num_scans, "be at least 1");
  if (!(step >= 0.0 && step <= 10.0)) return Violation("step", step, "lie in [0, 10]");
  if (!(scan_period > 0.0 && scan_period <= 1000.0)) return Violation("scan_period", scan_period, "lie in (0, 1000]");
  return lidar.Validate();
}

PlanarCorridor::PlanarCorridor(const PlanarCorridorOptions& options) : options_(options), lidar_(options.lidar) {
  const double begin = -2.0 * options.lidar.max_range;
  const double end = options.step * options.num_scans + 2.0 * options.lidar.max_range;
  for (const double y : {-0.5 * options.width, 0.5 * options.width}) {
    world_.walls.push_back({{begin, y}, {end, y}, options.roughness});
  }
}

LaserScan PlanarCorridor::Scan(size_t index) const {
  Random random(options_.seed, index);
  return lidar_.Measure(world_, TruePose(index), Stamp(index), Tilt{}, &random);
}

Trajectory PlanarCorridor::GroundTruth() const {
  Trajectory trajectory;
  for (size_t i = 0; i < NumScans(); ++i) trajectory.push_back({Stamp(i), TruePose(i)});
  return trajectory;
}

}  // namespace arborslam
