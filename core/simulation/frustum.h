#ifndef ARBORSLAM_CORE_SIMULATION_FRUSTUM_H_
#define ARBORSLAM_CORE_SIMULATION_FRUSTUM_H_

#include <Eigen/Core>

namespace arborslam {

/// A solid of circular cross-section that tapers evenly along its axis: a trunk, a post, a traffic cone, a limb.
struct Frustum {
  Eigen::Vector3d base = Eigen::Vector3d::Zero();   ///< [m], world, the lower end of the axis.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< Unit vector from there to the upper end.
  double length = 1.0;                              ///< [m] of the axis.
  double base_radius = 0.1;                         ///< [m].
  double top_radius = 0.1;                          ///< [m].

  /// The frustum whose axis leads from `base` to `top`, which must be apart.
  static Frustum Between(const Eigen::Vector3d& base, const Eigen::Vector3d& top, double base_radius,
                         double top_radius);

  /// [m], across the axis, `along` [m] from the base.
  double RadiusAt(double along) const { return base_radius + (top_radius - base_radius) * along / length; }
};

/// [m], the range at which the beam from `origin` along the unit vector `direction` enters the frustum through its side
/// or its upper end; infinite if it does not. The lower end stands in the ground.
double Intersect(const Frustum& frustum, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_FRUSTUM_H_
