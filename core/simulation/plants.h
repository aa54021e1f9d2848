#ifndef ARBORSLAM_CORE_SIMULATION_PLANTS_H_
#define ARBORSLAM_CORE_SIMULATION_PLANTS_H_

#include <Eigen/Core>

#include "core/simulation/random.h"
#include "core/simulation/world3.h"

namespace arborslam {

/// A tree. Plants of a kind differ at random from these figures.
struct TreeShape {
  double trunk_radius = 0.1;  ///< [m], at the ground.
  double trunk_height = 1.5;  ///< [m], to the trunk's upper end.
  double top_share = 0.6;     ///< Radius there over that at the ground.
  double lean = 3.0;          ///< [deg], standard deviation from the vertical.
  int limbs = 3;              ///< Thick branches into the crown.
  double crown_base = 1.0;    ///< [m] above the ground.
  double crown_top = 3.5;     ///< [m] above the ground.
  double crown_radius = 1.2;  ///< [m].
  int crown_parts = 3;        ///< Ellipsoids of leaves.
  double leaf_density = 0.8;  ///< [1/m].
};

/// Sets a tree at `place`.
void PlantTree(const Eigen::Vector2d& place, const TreeShape& shape, Random* random, World3* world);

/// Sets an upright post, which leans by about `lean` [deg].
void SetPost(const Eigen::Vector2d& place, double radius, double height, double lean, Random* random, World3* world);

/// Sets posts along the line from `begin` to `end`, about `spacing` [m] apart.
void SetFence(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double spacing, Random* random, World3* world);

/// Sets a bush.
void PlantBush(const Eigen::Vector2d& place, double radius, double height, double leaf_density, World3* world);

/// A row of leaves between two points, broken into pieces of about a metre that differ a little: a hedge or the leaf
/// wall of vines.
struct LeafWallShape {
  double bottom = 0.6;        ///< [m] above the ground.
  double top = 1.8;           ///< [m] above the ground.
  double thickness = 0.4;     ///< [m].
  double leaf_density = 3.0;  ///< [1/m].
  double gaps = 0.03;         ///< Probability that a piece is missing.
};
void PlantLeafWall(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, const LeafWallShape& shape, Random* random,
                   World3* world);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_PLANTS_H_
