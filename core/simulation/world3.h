#ifndef ARBORSLAM_CORE_SIMULATION_WORLD3_H_
#define ARBORSLAM_CORE_SIMULATION_WORLD3_H_

#include <functional>
#include <vector>

#include "core/simulation/frustum.h"
#include "core/simulation/leaves.h"
#include "core/simulation/uneven_ground.h"

namespace arborslam {

/// What a 3D lidar can see. World frame: z up along gravity.
struct World3 {
  UnevenGround terrain;
  std::vector<Frustum> solids;
  std::vector<Leaves> leaves;
  /// Solids that move: all there are at a time [s]. May be empty.
  std::function<std::vector<Frustum>(double)> moving;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_WORLD3_H_
