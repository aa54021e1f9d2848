#ifndef ARBORSLAM_CORE_SIMULATION_FOOTPRINT_MAP_H_
#define ARBORSLAM_CORE_SIMULATION_FOOTPRINT_MAP_H_

#include <Eigen/Core>

#include "core/io/map_io.h"
#include "core/simulation/world3.h"

namespace arborslam {

/// The map of a world that a perfect SLAM would make, in the world frame: a cell is occupied when it touches the
/// cross-section of a solid at some height from the ground to a metre above it, and free otherwise. Grass and leaves
/// leave no trace.
/// @param low, high [m], the corners of the rectangle that it shows; it is widened to whole multiples of `resolution`.
GridImage FootprintMap(const World3& world, const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_FOOTPRINT_MAP_H_
