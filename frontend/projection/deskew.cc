#include "frontend/projection/deskew.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>

#include "core/cpu_clones.h"

namespace arborslam {

ARBORSLAM_CPU_CLONES void Deskew(const LidarSweep& sweep, const std::vector<float>& phases, const SweepMotion& motion,
                                 std::vector<Eigen::Vector3f>* points) {
  const bool is_still = motion.velocity.isZero(0.0f) && motion.angular_velocity.isZero(0.0f);
  if (phases.empty() || is_still || !(sweep.duration > 0.0)) {
    points->assign(sweep.points.begin(), sweep.points.end());
    return;
  }
  CHECK_EQ(phases.size(), sweep.points.size());
  points->resize(sweep.points.size());
  const auto duration = static_cast<float>(sweep.duration);
  // With t the time since the middle: R = I + t A [w] + t^2 B [w]^2, translation = t v + t^2 B [w] v + t^3 C [w]^2 v.
  const float turn_rate_squared = motion.angular_velocity.squaredNorm();
  const Eigen::Vector3f w_v = motion.angular_velocity.cross(motion.velocity);
  const Eigen::Vector3f w_w_v = motion.angular_velocity.cross(w_v);
  const float w_x = motion.angular_velocity.x(), w_y = motion.angular_velocity.y(), w_z = motion.angular_velocity.z();
  const float v_x = motion.velocity.x(), v_y = motion.velocity.y(), v_z = motion.velocity.z();
  const float w_v_x = w_v.x(), w_v_y = w_v.y(), w_v_z = w_v.z();
  const float w_w_v_x = w_w_v.x(), w_w_v_y = w_w_v.y(), w_w_v_z = w_w_v.z();
  // In blocks, coordinate by coordinate, so that the compiler can vectorise.
  constexpr size_t kBlock = 64;
  float x[kBlock];
  float y[kBlock];
  float z[kBlock];
  for (size_t begin = 0; begin < phases.size(); begin += kBlock) {
    const size_t size = std::min(kBlock, phases.size() - begin);
    const Eigen::Vector3f* const from = sweep.points.data() + begin;
    for (size_t i = 0; i < size; ++i) {
      x[i] = from[i].x();
      y[i] = from[i].y();
      z[i] = from[i].z();
    }
    const float* const phase = phases.data() + begin;
    for (size_t i = 0; i < size; ++i) {
      const float t = (phase[i] - 0.5f) * duration;
      const float t_squared = t * t;
      const float angle_squared = t_squared * turn_rate_squared;
      const float a = t * (1.0f - angle_squared * (1.0f / 6.0f));
      const float b = t_squared * (0.5f - angle_squared * (1.0f / 24.0f));
      const float c = t_squared * t * (1.0f / 6.0f);
      const float w_p_x = w_y * z[i] - w_z * y[i];
      const float w_p_y = w_z * x[i] - w_x * z[i];
      const float w_p_z = w_x * y[i] - w_y * x[i];
      x[i] += a * w_p_x + b * (w_y * w_p_z - w_z * w_p_y + w_v_x) + t * v_x + c * w_w_v_x;
      y[i] += a * w_p_y + b * (w_z * w_p_x - w_x * w_p_z + w_v_y) + t * v_y + c * w_w_v_y;
      z[i] += a * w_p_z + b * (w_x * w_p_y - w_y * w_p_x + w_v_z) + t * v_z + c * w_w_v_z;
    }
    Eigen::Vector3f* const to = points->data() + begin;
    for (size_t i = 0; i < size; ++i) to[i] = Eigen::Vector3f(x[i], y[i], z[i]);
  }
}

std::vector<Eigen::Vector3f> Deskew(const LidarSweep& sweep, const std::vector<float>& phases,
                                    const SweepMotion& motion) {
  std::vector<Eigen::Vector3f> points;
  Deskew(sweep, phases, motion, &points);
  return points;
}

}  // namespace arborslam
