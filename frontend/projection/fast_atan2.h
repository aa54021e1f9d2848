#ifndef ARBORSLAM_FRONTEND_PROJECTION_FAST_ATAN2_H_
#define ARBORSLAM_FRONTEND_PROJECTION_FAST_ATAN2_H_

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

namespace arborslam {

/// atan2(y, x) [rad] to within 4e-6 rad, for finite arguments; 0 for (0, 0). An odd polynomial for the octant and
/// selections instead of branches, so that compilers can vectorise loops of it.
inline float FastAtan2(float y, float x) {
  constexpr float kTiny = 1e-30f;
  const float abs_x = std::abs(x);
  const float abs_y = std::abs(y);
  // Where a choice is a factor, compilers do not take it for two ways to go, and compute both to their ends.
  const float steep = abs_y > abs_x ? 1.0f : 0.0f;
  const float larger = abs_y > abs_x ? abs_y : abs_x;
  const float smaller = abs_x < abs_y ? abs_x : abs_y;
  const float t = smaller / (larger > kTiny ? larger : kTiny);
  const float u = t * t;
  // Minimax of atan(t) on [0, 1].
  float angle = t * (0.99997726f + u * (-0.33262347f +
                                        u * (0.19354346f + u * (-0.11643287f + u * (0.05265332f + u * -0.01172120f)))));
  angle = steep * 1.57079633f + (1.0f - 2.0f * steep) * angle;
  angle = x < 0.0f ? 3.14159265f - angle : angle;
  return y < 0.0f ? -angle : angle;
}

/// Azimuths [rad], from the x axis to the y axis in [-pi, pi], of `num_points` points.
void Azimuths(const Eigen::Vector3f* points, size_t num_points, float* azimuths);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_FAST_ATAN2_H_
