#ifndef ARBORSLAM_TESTS_FRONTEND_PROJECTION_RING_LIDAR_H_
#define ARBORSLAM_TESTS_FRONTEND_PROJECTION_RING_LIDAR_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/geometry/angles.h"
#include "core/sensor/lidar_sweep.h"
#include "core/simulation/random.h"

namespace arborslam {

/// Tiny worlds for tests of the projection: ground as a function of place, upright cylinders, and leaves.
struct TinyWorld {
  struct Cylinder {
    Eigen::Vector2d place;
    double radius;
    double height;  ///< [m], of its top above z = 0.
  };
  /// An upright cylinder full of leaves.
  struct Crown {
    Eigen::Vector2d place;
    double radius;
    double bottom;   ///< [m], above z = 0.
    double top;      ///< [m], above z = 0.
    double density;  ///< [1/m]
  };

  std::function<double(const Eigen::Vector2d&)> ground = [](const Eigen::Vector2d&) { return 0.0; };
  double grass = 0.0;  ///< [m], returns from the ground lie up to this much above it.
  std::vector<Cylinder> cylinders;
  std::vector<Crown> crowns;
};

/// What a lidar of `rings` rings between +-15 deg sees of `world` from T_world_lidar, column by column, clockwise from
/// behind, within 40 m. `noise` [m] is the standard deviation of ranges.
inline LidarSweep SeeTinyWorld(const TinyWorld& world, const Eigen::Isometry3d& T_world_lidar, double noise,
                               Random* random, int columns = 900, int rings = 16) {
  constexpr double kMaxRange = 40.0;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  LidarSweep sweep;
  sweep.duration = 0.1;
  const Eigen::Vector3d origin = T_world_lidar.translation();
  for (int column = 0; column < columns; ++column) {
    const double azimuth = kPi - 2.0 * kPi * column / columns;
    for (int ring = 0; ring < rings; ++ring) {
      const double elevation = DegToRad(-15.0 + 30.0 * ring / (rings - 1));
      const Eigen::Vector3d beam(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                                 std::sin(elevation));
      const Eigen::Vector3d direction = T_world_lidar.linear() * beam;
      double range = kInfinity;
      double step = 0.02;
      for (double r = 0.3; r < kMaxRange; r += step) {
        const Eigen::Vector3d p = origin + r * direction;
        const double above = p.z() - world.ground(p.head<2>());
        if (above <= 0.0) {
          const double climb =
              (origin + (r + 1e-3) * direction).z() - world.ground((origin + (r + 1e-3) * direction).head<2>()) - above;
          range = r - above / (climb / 1e-3);
          if (world.grass > 0.0 && climb < 0.0) range += random->Uniform() * world.grass / (climb / 1e-3);
          break;
        }
        step = std::max(0.02, 0.5 * above);
      }
      const double level = direction.head<2>().squaredNorm();
      // Where the beam is within `radius` of the vertical through `place`.
      const auto passage = [&](const Eigen::Vector2d& place, double radius, double* entry, double* exit) {
        const Eigen::Vector2d offset = origin.head<2>() - place;
        const double b = offset.dot(direction.head<2>());
        const double root = b * b - level * (offset.squaredNorm() - radius * radius);
        if (root <= 0.0) return false;
        *entry = (-b - std::sqrt(root)) / level;
        *exit = (-b + std::sqrt(root)) / level;
        return *entry > 0.0;
      };
      double entry = 0.0;
      double exit = 0.0;
      for (const TinyWorld::Cylinder& cylinder : world.cylinders) {
        if (!passage(cylinder.place, cylinder.radius, &entry, &exit) || entry > range) continue;
        if ((origin + entry * direction).z() <= cylinder.height) range = entry;
      }
      for (const TinyWorld::Crown& crown : world.crowns) {
        if (!passage(crown.place, crown.radius, &entry, &exit)) continue;
        const double met = entry + random->Exponential() / crown.density;
        const double z = (origin + met * direction).z();
        if (met < exit && met < range && z >= crown.bottom && z <= crown.top) range = met;
      }
      if (range > kMaxRange) continue;
      range += noise * random->Gaussian();
      sweep.points.push_back((range * beam).cast<float>());
    }
  }
  return sweep;
}

/// T_world_lidar at `height` [m] above z = 0, leaning by `roll` and `pitch` [deg].
inline Eigen::Isometry3d LidarAt(double height, double roll, double pitch) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(DegToRad(pitch), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(DegToRad(roll), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation().z() = height;
  return pose;
}

/// [deg], between the upright of the world and `normal` in the lidar frame.
inline double TiltError(const Eigen::Isometry3d& T_world_lidar, const Eigen::Vector3f& normal,
                        const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ()) {
  return RadToDeg(std::acos(std::clamp((T_world_lidar.linear() * normal.cast<double>()).dot(up), -1.0, 1.0)));
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_FRONTEND_PROJECTION_RING_LIDAR_H_
