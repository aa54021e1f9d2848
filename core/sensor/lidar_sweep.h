#ifndef ARBORSLAM_CORE_SENSOR_LIDAR_SWEEP_H_
#define ARBORSLAM_CORE_SENSOR_LIDAR_SWEEP_H_

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace arborslam {

/// One revolution of a 3D lidar, raw: every point in the frame that the sensor had when it measured the point (`lidar`:
/// x ahead, y left, z up, the origin where the beams come from).
struct LidarSweep {
  double start = 0.0;     ///< [s], when the sweep began. A pose that belongs to the sweep is stamped at its middle.
  double duration = 0.0;  ///< [s], how long it took: at least 0 and any of `times`.
  /// True: nothing in the recording told `duration`. It is the same in all sweeps of the recording then, and there are
  /// no `times`.
  bool is_duration_guessed = false;
  /// The moment of the sweep that its stamp named, as a share of the duration; what `start` was computed from.
  double stamp_phase = 0.0;
  std::vector<Eigen::Vector3f> points;  ///< [m], finite, none at the origin, in the order of the file.
  std::vector<float> times;             ///< [s] since `start`, one per point; empty when the recording has no times.
  /// Unit vector, lidar frame, about which the beams turn: not z where the frame is upright and the lidar tilted.
  Eigen::Vector3f spin_axis = Eigen::Vector3f::UnitZ();
  /// Why nothing could be read of it, for people; empty when it was read. A sweep with a fault has no points.
  std::string fault;
  size_t num_dropped = 0;  ///< Points of the record that were infinite, not a number, or at the origin.

  /// [s]
  double Middle() const { return start + 0.5 * duration; }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_LIDAR_SWEEP_H_
