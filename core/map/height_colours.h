#ifndef ARBORSLAM_CORE_MAP_HEIGHT_COLOURS_H_
#define ARBORSLAM_CORE_MAP_HEIGHT_COLOURS_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace arborslam {

/// Red, green, blue.
using Colour = std::array<uint8_t, 3>;

/// The colour at `t` in [0, 1] of the map "viridis" (Smith and van der Walt 2015, CC0), from dark blue to yellow: equal
/// steps look equal, and it reads without colour vision too. Values outside are clamped.
Colour Viridis(double t);

/// Heights [m] of `points` above the ground below them, z up. The ground is that of the lowest points: the least z in
/// a cell of 2 m and its neighbours, interpolated between cells, so that a hillside does not look like a tall tree.
/// Coordinates are finite and below 1e9 m.
std::vector<float> HeightsAboveGround(const std::vector<Eigen::Vector3f>& points);

/// A colour per point by its height above the ground, yellow from the 98th percentile of the heights on.
std::vector<Colour> ColourByHeight(const std::vector<Eigen::Vector3f>& points);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_HEIGHT_COLOURS_H_
