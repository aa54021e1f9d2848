#ifndef ARBORSLAM_CORE_SIMULATION_UNEVEN_GROUND_H_
#define ARBORSLAM_CORE_SIMULATION_UNEVEN_GROUND_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {

/// Uneven ground with grass on it.
struct UnevenGroundOptions {
  double undulation = 0.3;       ///< [m], the ground's long waves stay within this of the slope.
  double wavelength = 30.0;      ///< [m] of the long waves, mean.
  double slope = 0.0;            ///< [deg], of the ground as a whole.
  double slope_direction = 0.0;  ///< [deg], in which it rises, from the world's x axis to its y axis.
  double bumps = 0.01;           ///< [m], standard deviation of clods and tufts a quarter of a metre apart.
  double grass_height = 0.1;     ///< [m], of the usual grass; 0: none.
  double grass_cover = 0.6;      ///< Share of the ground that grass stands on.
  double grass_clumps = 0.02;    ///< Share of the ground with clumps of two and a half times the height.
  double grass_density = 3.0;    ///< [1/m], a beam in the grass meets a blade every 1/density metres.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("undulation", undulation);
    visit("wavelength", wavelength);
    visit("slope", slope);
    visit("slope_direction", slope_direction);
    visit("bumps", bumps);
    visit("grass_height", grass_height);
    visit("grass_cover", grass_cover);
    visit("grass_clumps", grass_clumps);
    visit("grass_density", grass_density);
  }
};

/// The ground as a height over the plane. Its waves and its slope are smooth functions, which a robot's body follows;
/// the beams of a lidar see in addition the bumps, on a bilinear grid. The ground is at height 0 in the origin but for
/// the bumps. Thread-safe.
class UnevenGround {
 public:
  /// `options` must be valid. Beams meet ground on the rectangle from `low` to `high` [m] only.
  UnevenGround(const UnevenGroundOptions& options, uint64_t seed, const Eigen::Vector2d& low,
               const Eigen::Vector2d& high);

  /// [m], without the bumps.
  double SmoothHeight(const Eigen::Vector2d& position) const { return slope_.dot(position) + Waves(position); }

  /// Gradient of SmoothHeight.
  Eigen::Vector2d SmoothGradient(const Eigen::Vector2d& position) const;

  /// [m], with the bumps.
  double Height(const Eigen::Vector2d& position) const { return slope_.dot(position) + Sample(position, ground_); }

  /// [m] above the ground.
  double GrassHeight(const Eigen::Vector2d& position) const { return grass_.empty() ? 0.0 : Sample(position, grass_); }

  /// [m], where the beam from `origin` along the unit vector `direction` meets the soil or, at random, a blade of
  /// grass, within `max_range`; infinite if it meets nothing. The grass is a medium of constant density below its
  /// height.
  double Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double max_range, Random* random) const;

  /// [m], where the beam is as low as the lowest ground: nothing is farther; infinite if it never is.
  double RangeToFloor(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Wave {
    Eigen::Vector2d wave_number;  // [rad/m].
    double phase;                 // [rad].
    double amplitude;             // [m].
  };

  // How high the ground rises within `reach` of each square of `reach` by `reach` cells.
  struct Peaks {
    Peaks() = default;
    Peaks(const std::vector<float>& nodes, int width, int height, int reach);
    // Around the cell (i, j).
    double At(int i, int j) const {
      return heights[static_cast<size_t>(j / reach) * static_cast<size_t>(across) + static_cast<size_t>(i / reach)];
    }

    int reach = 1;   // [cells].
    int across = 0;  // [squares].
    std::vector<float> heights;
  };

  double Waves(const Eigen::Vector2d& position) const;
  double Sample(const Eigen::Vector2d& position, const std::vector<float>& nodes) const;

  // The first range from `begin` on at which the beam is no more than `offset` above the soil; infinite if none.
  double Descend(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double begin, double max_range,
                 double offset) const;

  Eigen::Vector2d slope_;
  std::vector<Wave> waves_;
  double offset_ = 0.0;  // [m], so that the waves vanish in the origin.
  double grass_density_;
  double max_grass_ = 0.0;  // [m].

  Eigen::Vector2d low_;
  int width_ = 0;              // [nodes].
  int height_ = 0;             // [nodes].
  std::vector<float> ground_;  // [m], without the slope.
  std::vector<float> grass_;   // [m] above the ground; empty: none.
  double highest_ = 0.0;       // [m], of the nodes.
  double lowest_ = 0.0;        // [m].
  std::array<Peaks, 3> peaks_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_UNEVEN_GROUND_H_
