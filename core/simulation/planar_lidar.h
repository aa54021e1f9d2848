#ifndef ARBORSLAM_CORE_SIMULATION_PLANAR_LIDAR_H_
#define ARBORSLAM_CORE_SIMULATION_PLANAR_LIDAR_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/sensor/laser_scan.h"
#include "core/simulation/planar_world.h"
#include "core/simulation/random.h"

namespace arborslam {

/// A planar lidar that looks all around. The defaults are those of the Pullally recordings (VLP-16, one ring).
struct PlanarLidarOptions {
  int beams = 897;                  ///< Bearing of beam i: -pi + i 2 pi / (beams + 1).
  double min_range = 0.3;           ///< [m], nearer things return nothing.
  double max_range = 30.0;          ///< [m], farther things return nothing.
  double range_noise = 0.03;        ///< [m], standard deviation.
  double range_resolution = 0.002;  ///< [m], ranges are multiples of it; 0: exact.
  double drop_out = 0.02;           ///< Probability that a beam is lost.
  double sensor_height = 0.45;      ///< [m] above the ground.
  double ground_roughness = 0.05;   ///< [m], standard deviation of ground returns in range.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("beams", beams);
    visit("min_range", min_range);
    visit("max_range", max_range);
    visit("range_noise", range_noise);
    visit("range_resolution", range_resolution);
    visit("drop_out", drop_out);
    visit("sensor_height", sensor_height);
    visit("ground_roughness", ground_roughness);
  }
};

/// How far the scan plane leans from the horizontal.
struct Tilt {
  double angle = 0.0;      ///< [rad], at least 0 and below pi/2.
  double direction = 0.0;  ///< [rad], bearing in the sensor frame in which the plane goes down steepest.
};

/// Simulates a planar lidar. Thread-safe.
class PlanarLidar {
 public:
  /// `options` must be valid.
  explicit PlanarLidar(const PlanarLidarOptions& options);

  /// One scan from `T_world_lidar`. Lost beams and those without a return are +infinity. A tilted scan plane meets the
  /// ground in a straight line at sensor_height / tan(angle) ahead of `direction`, which hides what is behind it.
  LaserScan Measure(const PlanarWorld& world, const SE2& T_world_lidar, double stamp, const Tilt& tilt,
                    Random* random) const;

 private:
  // Calls visit(beam) for the beams whose bearing lies within `half_width` of `bearing` [rad].
  template <class Visit>
  void VisitBeams(double bearing, double half_width, Visit&& visit) const;

  void HitDisc(const Eigen::Vector2d& center, double radius, std::vector<double>* ranges) const;
  void HitFoliage(const Foliage& foliage, const Eigen::Vector2d& center, Random* random,
                  std::vector<double>* ranges) const;
  void HitWall(const Wall& wall, const SE2& T_lidar_world, Random* random, std::vector<double>* ranges) const;
  void HitGround(const Tilt& tilt, Random* random, std::vector<double>* ranges) const;

  PlanarLidarOptions options_;
  double bearing_increment_;
  std::vector<Eigen::Vector2d> directions_;  // Unit vectors of the beams in the lidar frame.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_PLANAR_LIDAR_H_
