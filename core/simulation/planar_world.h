#ifndef ARBORSLAM_CORE_SIMULATION_PLANAR_WORLD_H_
#define ARBORSLAM_CORE_SIMULATION_PLANAR_WORLD_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// An opaque disc: a trunk or a post.
struct Disc {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< [m], world.
  double radius = 0.1;                               ///< [m].
};

/// A disc of leaves. A beam returns from a leaf met at random, anew in every scan: the way into the leaves is
/// exponentially distributed with mean 1/density (Beer's law), and what is left over passes through.
struct Foliage {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< [m], world.
  double radius = 0.4;                               ///< [m].
  double density = 0.4;                              ///< [1/m], at least 0.
};

/// A straight wall or hedge between two points.
struct Wall {
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();  ///< [m], world.
  Eigen::Vector2d end = Eigen::Vector2d::Zero();    ///< [m], world.
  double roughness = 0.0;                           ///< [m], mean depth at which a beam returns from behind the line.
};

/// What a planar lidar can see.
struct PlanarWorld {
  std::vector<Disc> discs;
  std::vector<Foliage> foliage;
  std::vector<Wall> walls;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_PLANAR_WORLD_H_
