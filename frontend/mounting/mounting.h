#ifndef ARBORSLAM_FRONTEND_MOUNTING_MOUNTING_H_
#define ARBORSLAM_FRONTEND_MOUNTING_MOUNTING_H_

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// How the frame of a recording's points stands over the ground.
struct MountingEstimate {
  size_t num_sweeps = 0;    ///< That were examined.
  size_t num_agreeing = 0;  ///< That agree on `up`.
  bool ok = false;          ///< False when fewer than half of the sweeps agree; the rest is then void.
  Eigen::Vector3f up = Eigen::Vector3f::UnitZ();  ///< Unit vector in the frame of the points.
  float height = 0.0f;  ///< [m], of the frame's origin above the ground; negative where it is below.
};

/// Finds the ground in every sweep (`SearchGround`), in all directions, and what most sweeps agree on. In a sweep where
/// a plane that an upright lidar may see explains about as much as the best one, it counts: a floor does not become
/// the ceiling, nor a wall the ground. A sweep that is tilted because the robot is, or because the ground slopes, is
/// told from a tilted lidar by the tilt only.
MountingEstimate EstimateMounting(const std::vector<LidarSweep>& sweeps);

/// True where the estimation takes sweeps as they are: the lidar leans by less than 20 deg.
bool IsUsualTilt(const Eigen::Vector3f& up);

/// Likewise: the lidar is 0.1 to 5.5 m above the ground.
bool IsUsualHeight(float height);

/// The axis of the frame, in either direction, that `up` is within 10 deg of: a lidar that lies on its side or hangs
/// upside down does so squarely, and the rest is the lean of the robot and the slope of the ground, which the
/// estimation finds for every sweep. `up` where there is none.
Eigen::Vector3f SnappedToAxis(const Eigen::Vector3f& up);

/// R_upright_lidar: the rotation that takes `up` (unit vector, lidar frame) to the z axis. The x axis of the lidar
/// keeps its heading, so that a lidar that leans, or hangs upside down, sees ahead what it saw ahead. Where x is within
/// 20 deg of the vertical, the y axis stays on its side instead: ahead is then z or -z, where a lidar pitched to this
/// attitude saw ahead. Proper for every `up`: nothing is mirrored.
Eigen::Matrix3f UprightRotation(const Eigen::Vector3f& up);

/// True where `UprightRotation` keeps the heading of the x axis.
bool KeepsHeadingOfX(const Eigen::Vector3f& up);

/// The height [m], over the origin of the upright frame of `sweeps`, from which the beams come: that at which the
/// returns lie on the fewest cones about the vertical, as those of an upright spinning lidar do. Nothing where they do
/// so no less at the origin, or nowhere.
/// @param origin_height [m], of the frame's origin above the ground.
std::optional<float> BeamOriginHeight(const std::vector<LidarSweep>& sweeps, float origin_height);

/// "upside down (roll 178 deg, pitch 2 deg)", "on its side (...)" or "tilted (...)": how a lidar with this `up` is
/// mounted. Angles are those of R_upright_lidar = Ry(pitch) Rx(roll).
std::string MountingText(const Eigen::Vector3f& up);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MOUNTING_MOUNTING_H_
