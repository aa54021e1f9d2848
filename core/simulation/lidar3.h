#ifndef ARBORSLAM_CORE_SIMULATION_LIDAR3_H_
#define ARBORSLAM_CORE_SIMULATION_LIDAR3_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "core/sensor/lidar_sweep.h"
#include "core/simulation/bearing_index.h"
#include "core/simulation/random.h"
#include "core/simulation/world3.h"

namespace arborslam {

/// A spinning lidar. The defaults are those of a Velodyne VLP-16 at 10 Hz.
struct Lidar3Options {
  int rings = 16;                   ///< Beams above one another, fired at once.
  double lowest_beam = -15.0;       ///< [deg], elevation.
  double highest_beam = 15.0;       ///< [deg], elevation.
  int columns = 1800;               ///< Firings in a revolution.
  double first_bearing = 180.0;     ///< [deg], of the first firing; the others follow clockwise as seen from above.
  double sweep_duration = 0.1;      ///< [s], of a revolution.
  double sweep_period = 0.1;        ///< [s], from the start of a recorded sweep to that of the next.
  double min_range = 0.5;           ///< [m], nearer things return nothing.
  double max_range = 100.0;         ///< [m], farther things return nothing.
  double range_noise = 0.02;        ///< [m], standard deviation.
  double range_resolution = 0.002;  ///< [m], ranges are multiples of it; 0: exact.
  double drop_out = 0.02;           ///< Probability that a return is lost.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("rings", rings);
    visit("lowest_beam", lowest_beam);
    visit("highest_beam", highest_beam);
    visit("columns", columns);
    visit("first_bearing", first_bearing);
    visit("sweep_duration", sweep_duration);
    visit("sweep_period", sweep_period);
    visit("min_range", min_range);
    visit("max_range", max_range);
    visit("range_noise", range_noise);
    visit("range_resolution", range_resolution);
    visit("drop_out", drop_out);
  }
};

/// An Ouster OS1-16 at 10 Hz with 0.18 deg between firings.
Lidar3Options Os1Options();

/// Simulates a spinning lidar in a world. Thread-safe.
class Lidar3 {
 public:
  /// `options` must be valid; `world` is borrowed and must not change.
  Lidar3(const Lidar3Options& options, const World3* world);

  /// The sweep that begins at `start` [s]; column i of n is fired `i / n` of the sweep's duration later, from the pose
  /// T_world_lidar = pose_at(time) of that moment. Points stand column by column, in each from the lowest ring up.
  LidarSweep Measure(const std::function<Eigen::Isometry3d(double)>& pose_at, double start, Random* random) const;

 private:
  // [m], where one exact beam ends; infinite if it meets nothing. `moving`: the moving solids that may be in its way.
  double Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const BearingIndex& index,
              const std::vector<Frustum>& moving, Random* random) const;

  Lidar3Options options_;
  const World3* world_;
  std::vector<Bounds> bounds_;               // Of the solids, then of the leaves.
  std::vector<Eigen::Vector2d> elevations_;  // Cosine and sine of each ring's.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_LIDAR3_H_
