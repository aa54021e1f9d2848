#ifndef ARBORSLAM_CORE_GEOMETRY_TILT_H_
#define ARBORSLAM_CORE_GEOMETRY_TILT_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry/se2.h"

namespace arborslam {

/// How a lidar leans and how high it is, over the frame `base` that stands upright below it and has its heading: what a
/// pose in space has beyond a pose in the plane.
struct Tilt3 {
  double roll = 0.0;   ///< [rad], R_base_lidar = Ry(pitch) * Rx(roll).
  double pitch = 0.0;  ///< [rad], positive: nose down.
  double z = 0.0;      ///< [m], the lidar above the plane z = 0 of base.

  /// R_base_lidar. The lidar's x axis has no y component in base: the heading is the planar pose's alone.
  Eigen::Matrix3d Rotation() const;

  /// T_base_lidar.
  Eigen::Isometry3d Transform() const;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(roll, pitch, z);
  }
};

/// The tilt (without z) nearest to a rotation R_base_lidar whose heading is left out.
Tilt3 TiltOf(const Eigen::Matrix3d& rotation);

/// The tilt (without z) that turns `up` (unit vector, lidar frame) upright.
Tilt3 TiltFromUp(const Eigen::Vector3d& up);

/// T_map_lidar of a lidar over the planar pose T_map_base.
Eigen::Isometry3d Lift(const SE2& T_map_base, const Tilt3& tilt);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_GEOMETRY_TILT_H_
