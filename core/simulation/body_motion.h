#ifndef ARBORSLAM_CORE_SIMULATION_BODY_MOTION_H_
#define ARBORSLAM_CORE_SIMULATION_BODY_MOTION_H_

#include <cstdint>
#include <string>
#include <vector>

namespace arborslam {

/// How a sensor's carrier moves about its mean course.
struct BodyOffset {
  double left = 0.0;   ///< [m].
  double up = 0.0;     ///< [m].
  double roll = 0.0;   ///< [rad].
  double pitch = 0.0;  ///< [rad].
  double yaw = 0.0;    ///< [rad].
};

/// The restlessness of a carrier, a smooth function of time: `wheeled` vibrates a little; `trot` is a legged robot
/// whose footfalls, at irregular times, jolt roll and pitch by up to 3 deg, and which bounces, sways and jitters in
/// yaw; `handheld` sways slowly by several degrees and bounces with every step. Thread-safe.
class BodyMotion {
 public:
  /// Names of the kinds.
  static const std::vector<std::string>& Kinds();

  /// @param kind one of `Kinds()`.
  /// @param scale multiplies all offsets.
  /// @param duration [s], until when there are footfalls.
  BodyMotion(const std::string& kind, double scale, double duration, uint64_t seed);

  /// At `time` [s].
  BodyOffset At(double time) const;

 private:
  // A sine of slowly varying phase.
  struct Oscillation {
    double BodyOffset::*component;
    double amplitude;         // [m] or [rad].
    double frequency;         // [rad/s].
    double phase;             // [rad].
    double wobble;            // [rad], by how much the phase strays.
    double wobble_frequency;  // [rad/s].
  };
  struct Footfall {
    double time;   // [s].
    double roll;   // [rad], of the jolt.
    double pitch;  // [rad].
    double drop;   // [m].
  };

  std::vector<Oscillation> oscillations_;
  std::vector<Footfall> footfalls_;  // About equally spaced in time.
  double scale_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_BODY_MOTION_H_
