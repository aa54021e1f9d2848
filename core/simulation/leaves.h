#ifndef ARBORSLAM_CORE_SIMULATION_LEAVES_H_
#define ARBORSLAM_CORE_SIMULATION_LEAVES_H_

#include <Eigen/Core>

namespace arborslam {

/// A volume of leaves, an ellipsoid or a box. A beam returns from a leaf met at random, anew in every sweep: the way
/// into the leaves is exponentially distributed with mean 1/density (Beer's law), and what is left over passes through.
struct Leaves {
  enum class Shape { kEllipsoid, kBox };

  Shape shape = Shape::kEllipsoid;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< [m], world.
  Eigen::Vector3d extent =
      Eigen::Vector3d::Ones();  ///< [m], the half axes, or half of the box's length, width, height.
  double yaw = 0.0;             ///< [rad], about the vertical.
  double density = 1.0;         ///< [1/m], more than 0.
};

/// The part of a beam that lies in leaves, [m] from its origin; empty when `entry` >= `exit`.
struct Passage {
  double entry = 0.0;
  double exit = 0.0;
};

/// Where the beam from `origin` along the unit vector `direction` passes the leaves; `entry` is 0 when it begins there.
Passage PassageThrough(const Leaves& leaves, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_LEAVES_H_
