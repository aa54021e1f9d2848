#ifndef ARBORSLAM_CORE_SIMULATION_SIMULATED_RUN_H_
#define ARBORSLAM_CORE_SIMULATION_SIMULATED_RUN_H_

#include <cstddef>
#include <memory>
#include <string>

#include "core/io/map_io.h"
#include "core/sensor/trajectory3.h"
#include "core/simulation/carrier.h"
#include "core/simulation/closed_path.h"
#include "core/simulation/lidar3.h"
#include "core/simulation/uneven_ground.h"
#include "core/simulation/world3.h"

namespace arborslam {

/// What the simulated runs in 3D have in common; the keys stand in the scenario's section.
struct RunOptions {
  int seed = 1;                  ///< Everything random follows from it.
  int num_scans = 0;             ///< 0: once around the path.
  int followers = 0;             ///< People who walk behind the carrier.
  double map_resolution = 0.05;  ///< [m], of the ground-truth map.
  double map_margin = 10.0;      ///< [m], how far that reaches beyond the path.
  UnevenGroundOptions terrain;
  CarrierOptions carrier;
  Lidar3Options lidar;

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("seed", seed);
    visit("num_scans", num_scans);
    visit("followers", followers);
    visit("map_resolution", map_resolution);
    visit("map_margin", map_margin);
    terrain.VisitFields(visit);
    carrier.VisitFields(visit);
    lidar.VisitFields(visit);
  }
};

/// A world and the way through it.
struct Scene {
  ClosedPath path;
  World3 world;
};

/// [m], the corners of the upright rectangle around a path.
struct Extent {
  Eigen::Vector2d low;
  Eigen::Vector2d high;
};
Extent ExtentOf(const ClosedPath& path);

/// The terrain under everything that can be seen from `path`.
UnevenGround GroundAround(const ClosedPath& path, const RunOptions& options);

/// A recording of a lidar that is carried once around a path, with its exact ground truth. Every sweep follows from the
/// options and its index alone: sweeps can be drawn in any order, and from several threads.
class SimulatedRun {
 public:
  /// `options` must be valid.
  SimulatedRun(const RunOptions& options, Scene scene);
  SimulatedRun(const SimulatedRun&) = delete;
  SimulatedRun& operator=(const SimulatedRun&) = delete;

  size_t NumScans() const { return num_scans_; }

  /// [s], when sweep `index` begins.
  double Start(size_t index) const { return options_.lidar.sweep_period * static_cast<double>(index); }

  /// [s], the middle of sweep `index`.
  double Middle(size_t index) const { return Start(index) + 0.5 * options_.lidar.sweep_duration; }

  LidarSweep Sweep(size_t index) const;

  /// T_world_lidar at Middle(index).
  Eigen::Isometry3d TruePose(size_t index) const { return carrier_.PoseAt(Middle(index)); }

  /// TruePose of every sweep.
  Trajectory3 GroundTruth() const;

  /// What the carrier's odometry says at Middle(index): its velocity with errors of scale, bias and noise.
  OdometryVelocity Control(size_t index) const;

  /// The solids seen from above (see `FootprintMap`).
  GridImage Map() const;

  const World3& world() const { return scene_.world; }
  const Carrier& carrier() const { return carrier_; }

  /// [m], once around.
  double PathLength() const { return scene_.path.Length(); }

 private:
  RunOptions options_;
  Scene scene_;
  Carrier carrier_;
  Lidar3 lidar_;
  size_t num_scans_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_SIMULATED_RUN_H_
