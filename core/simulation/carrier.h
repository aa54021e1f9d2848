#ifndef ARBORSLAM_CORE_SIMULATION_CARRIER_H_
#define ARBORSLAM_CORE_SIMULATION_CARRIER_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>

#include "core/geometry/se2.h"
#include "core/simulation/body_motion.h"
#include "core/simulation/closed_path.h"
#include "core/simulation/spline_path.h"
#include "core/simulation/uneven_ground.h"

namespace arborslam {

/// The robot or the person that carries the lidar.
struct CarrierOptions {
  std::string motion = "wheeled";  ///< wheeled, trot or handheld.
  double speed = 1.0;              ///< [m/s].
  double sensor_height = 0.6;      ///< [m] above the ground.
  double turn_radius = 1.0;        ///< [m].
  double wander = 0.15;            ///< [m], how far the path strays slowly to the sides.
  double restlessness = 1.0;       ///< Multiplies the motion's jolts, bounce and sway.
  double ground_following = 1.0;   ///< Share of the ground's tilt that the sensor takes over: 0 stays level.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("motion", motion);
    visit("speed", speed);
    visit("sensor_height", sensor_height);
    visit("turn_radius", turn_radius);
    visit("wander", wander);
    visit("restlessness", restlessness);
    visit("ground_following", ground_following);
  }
};

/// Motion in the plane, in the carrier's own frame.
struct OdometryVelocity {
  double forward = 0.0;  ///< [m/s].
  double left = 0.0;     ///< [m/s].
  double yaw = 0.0;      ///< [rad/s].
};

/// Carries a lidar once around a closed path over uneven ground, from a second's rest to rest. Poses are a smooth
/// function of time. Thread-safe.
class Carrier {
 public:
  /// `options` must be valid; `terrain` is borrowed.
  Carrier(const CarrierOptions& options, const ClosedPath& path, const UnevenGround* terrain, uint64_t seed);

  /// [s], from the beginning of the first rest to the end of the last.
  double Duration() const { return duration_; }

  /// [m] along the path at `time` [s].
  double DistanceAt(double time) const;

  /// Place and heading `distance` [m] along the path, without the motion about it.
  SE2 OnPath(double distance) const { return path_.At(distance); }

  /// T_world_lidar at `time` [s]; before 0 and after Duration() it rests.
  Eigen::Isometry3d PoseAt(double time) const;

  /// Of the mean course, as a robot's odometry tells it, at `time` [s].
  OdometryVelocity VelocityAt(double time) const;

 private:
  // How much of its full speed the carrier has, in [0, 1], and the distance at a speed of 1 m/s.
  double SpeedShare(double time) const;
  double NominalDistance(double time) const;

  CarrierOptions options_;
  SplinePath path_;
  const UnevenGround* terrain_;
  double duration_;
  BodyMotion body_motion_;
  double surge_phase_;  // [rad].
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_CARRIER_H_
