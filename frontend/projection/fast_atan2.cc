#include "frontend/projection/fast_atan2.h"

#include <algorithm>

#include "core/cpu_clones.h"

namespace arborslam {

ARBORSLAM_CPU_CLONES void Azimuths(const Eigen::Vector3f* points, size_t num_points, float* azimuths) {
  constexpr size_t kBlock = 64;
  float x[kBlock];
  float y[kBlock];
  for (size_t begin = 0; begin < num_points; begin += kBlock) {
    const size_t size = std::min(kBlock, num_points - begin);
    for (size_t i = 0; i < size; ++i) {
      x[i] = points[begin + i].x();
      y[i] = points[begin + i].y();
    }
    for (size_t i = 0; i < size; ++i) azimuths[begin + i] = FastAtan2(y[i], x[i]);
  }
}

}  // namespace arborslam
