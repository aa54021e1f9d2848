#ifndef ARBORSLAM_CORE_SENSOR_PLANAR_SCAN_H_
#define ARBORSLAM_CORE_SENSOR_PLANAR_SCAN_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// What the matcher and the maps eat: a sweep reduced to the plane (paper eq. 7), in the `base` frame.
struct PlanarScan {
  double stamp = 0.0;                      ///< [s], the middle of the sweep.
  std::vector<Eigen::Vector2f> points;     ///< [m], returns; the rays from the origin to them are free.
  std::vector<float> weights;              ///< Number of returns that each point stands for; empty: one each.
  std::vector<Eigen::Vector2f> free_ends;  ///< [m], ends of rays that are known to be free and met nothing.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_PLANAR_SCAN_H_
