#ifndef ARBORSLAM_CORE_SIMULATION_PERSON_H_
#define ARBORSLAM_CORE_SIMULATION_PERSON_H_

#include <array>

#include "core/geometry/se2.h"
#include "core/simulation/frustum.h"

namespace arborslam {

/// Two legs, body and head of a person who stands at `place` (T_world_person) on ground of height `ground` [m]: `swing`
/// in [-1, 1] is how far the left leg is ahead.
std::array<Frustum, 4> PersonAt(const SE2& place, double ground, double height, double swing);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_PERSON_H_
