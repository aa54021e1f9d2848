#ifndef ARBORSLAM_CORE_SIMULATION_PLANAR_CORRIDOR_H_
#define ARBORSLAM_CORE_SIMULATION_PLANAR_CORRIDOR_H_

#include <cstddef>
#include <string>

#include "core/geometry/se2.h"
#include "core/sensor/laser_scan.h"
#include "core/sensor/stamped_pose.h"
#include "core/simulation/planar_lidar.h"
#include "core/simulation/planar_world.h"

namespace arborslam {

/// A corridor without ends: nothing in its scans tells how far along it the robot is.
struct PlanarCorridorOptions {
  int seed = 1;              ///< Everything random follows from it.
  double width = 3.0;        ///< [m] between the walls.
  double roughness = 0.0;    ///< [m], mean depth of the walls' surface.
  int num_scans = 100;       ///< In the run.
  double step = 0.28;        ///< [m] between scans.
  double scan_period = 1.0;  ///< [s] between scans.
  PlanarLidarOptions lidar;  ///< Its keys stand in the same section.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("seed", seed);
    visit("width", width);
    visit("roughness", roughness);
    visit("num_scans", num_scans);
    visit("step", step);
    visit("scan_period", scan_period);
    lidar.VisitFields(visit);
  }
};

/// Two parallel walls along x, which reach out of the lidar's sight at both ends, and a robot that goes from the origin
/// straight along +x midway between them. Scans can be drawn in any order.
class PlanarCorridor {
 public:
  /// `options` must be valid.
  explicit PlanarCorridor(const PlanarCorridorOptions& options);

  size_t NumScans() const { return static_cast<size_t>(options_.num_scans); }

  /// Scan `index`, in the robot's frame; its stamp is index * scan_period.
  LaserScan Scan(size_t index) const;

  /// T_world_base of scan `index`.
  SE2 TruePose(size_t index) const { return SE2(options_.step * static_cast<double>(index), 0.0, 0.0); }

  /// TruePose of every scan.
  Trajectory GroundTruth() const;

 private:
  double Stamp(size_t index) const { return options_.scan_period * static_cast<double>(index); }

  PlanarCorridorOptions options_;
  PlanarLidar lidar_;
  PlanarWorld world_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_PLANAR_CORRIDOR_H_
