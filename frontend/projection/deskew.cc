#include "frontend/projection/deskew.h"

#include <glog/logging.h>

#include <Eigen/Geometry>

namespace arborslam {

void Deskew(const LidarSweep& sweep, const std::vector<float>& phases, const SweepMotion& motion,
            std::vector<Eigen::Vector3f>* points) {
  const bool is_still = motion.velocity.isZero(0.0f) && motion.angular_velocity.isZero(0.0f);
  if (phases.empty() || is_still || !(sweep.duration > 0.0)) {
    points->assign(sweep.points.begin(), sweep.points.end());
    return;
  }
  CHECK_EQ(phases.size(), sweep.points.size());
  points->resize(sweep.points.size());
  const auto duration = static_cast<float>(sweep.duration);
  const Eigen::Vector3f& w = motion.angular_velocity;
  const Eigen::Vector3f& v = motion.velocity;
  // With t the time since the middle: R = I + t A [w] + t^2 B [w]^2, translation = t v + t^2 B [w] v + t^3 C [w]^2 v.
  const float turn_rate_squared = w.squaredNorm();
  const Eigen::Vector3f w_v = w.cross(v);
  const Eigen::Vector3f w_w_v = w.cross(w_v);
  for (size_t i = 0; i < phases.size(); ++i) {
    const Eigen::Vector3f p = sweep.points[i];
    const float t = (phases[i] - 0.5f) * duration;
    const float t_squared = t * t;
    const float angle_squared = t_squared * turn_rate_squared;
    const float a = t * (1.0f - angle_squared * (1.0f / 6.0f));
    const float b = t_squared * (0.5f - angle_squared * (1.0f / 24.0f));
    const float c = t_squared * t * (1.0f / 6.0f);
    const Eigen::Vector3f w_p = w.cross(p);
    (*points)[i] = p + a * w_p + b * (w.cross(w_p) + w_v) + t * v + c * w_w_v;
  }
}

std::vector<Eigen::Vector3f> Deskew(const LidarSweep& sweep, const std::vector<float>& phases,
                                    const SweepMotion& motion) {
  std::vector<Eigen::Vector3f> points;
  Deskew(sweep, phases, motion, &points);
  return points;
}

}  // namespace arborslam
