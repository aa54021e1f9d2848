#ifndef ARBORSLAM_CORE_SENSOR_PLANAR_SCAN_H_
#define ARBORSLAM_CORE_SENSOR_PLANAR_SCAN_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// What the matcher and the maps eat: a sweep reduced to the plane (paper eq. 7), in the `base` frame.
struct PlanarScan {
  double stamp = 0.0;                   ///< [s], the middle of the sweep.
  std::vector<Eigen::Vector2f> points;  ///< [m], returns.
  std::vector<float> weights;           ///< Number of returns that each point stands for; empty: one each.
  /// When in the sweep each point was measured, as a share of the sweep's duration in [0, 1]; empty: not known.
  std::vector<float> phases;
  std::vector<Eigen::Vector2f> free_ends;  ///< [m], ends of rays that are known to be free and met nothing.
  /// [m], the nearest return in each small sector of bearing that has any, also of those that became no points (leaves,
  /// for one): how far one can look. Empty for a lidar in the plane, whose returns are all points.
  std::vector<Eigen::Vector2f> first_returns;
  /// True for a lidar in the plane: the rays from the origin to the points are free. A sweep in space sees over things:
  /// a ray to a far trunk may pass above a near post, and only `free_ends` tell what is free.
  bool point_rays_are_free = true;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(stamp, points, weights, phases, free_ends, first_returns, point_rays_are_free);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_PLANAR_SCAN_H_
