#ifndef ARBORSLAM_FRONTEND_PROJECTION_DESKEW_H_
#define ARBORSLAM_FRONTEND_PROJECTION_DESKEW_H_

#include <Eigen/Core>
#include <vector>

#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// How the lidar moves during a sweep: a constant twist in its own frame.
struct SweepMotion {
  Eigen::Vector3f velocity = Eigen::Vector3f::Zero();          ///< [m/s], along the lidar's own axes.
  Eigen::Vector3f angular_velocity = Eigen::Vector3f::Zero();  ///< [rad/s], about the lidar's own axes.
};

/// The points of `sweep` as the lidar would have seen them at the sweep's middle: p + A w x p + B w x (w x p) + the
/// translation, w being the turn between the point's time and the middle. The series of the exponential map are cut
/// after w^4, which leaves |w|^5 / 120 of the range and, in the translation, |w|^4 / 120 of the way: 1e-7 and 1e-6 for
/// w = 0.1 rad.
/// @param phases as `PointPhases` gives them; if empty, the points come back as they are.
std::vector<Eigen::Vector3f> Deskew(const LidarSweep& sweep, const std::vector<float>& phases,
                                    const SweepMotion& motion);

/// The same into `points`, whose memory is used again.
void Deskew(const LidarSweep& sweep, const std::vector<float>& phases, const SweepMotion& motion,
            std::vector<Eigen::Vector3f>* points);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_DESKEW_H_
