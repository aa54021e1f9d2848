#ifndef ARBORSLAM_CORE_SIMULATION_BEARING_INDEX_H_
#define ARBORSLAM_CORE_SIMULATION_BEARING_INDEX_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/simulation/world3.h"

namespace arborslam {

/// The upright cylinder around a thing.
struct Bounds {
  Eigen::Vector2d center;  ///< [m], world.
  double radius;           ///< [m].
  double low;              ///< [m].
  double high;             ///< [m].
};

Bounds BoundsOf(const Frustum& frustum);
Bounds BoundsOf(const Leaves& leaves);

/// The things around a place by the directions in which they stand, so that a beam need be tested only with those in
/// its way, nearest first.
class BearingIndex {
 public:
  /// A thing in a direction.
  struct Entry {
    float near;      ///< [m], where a level beam can meet it at the earliest.
    float far;       ///< [m], at the latest.
    float low;       ///< [m], its lowest height.
    float high;      ///< [m], its highest.
    uint32_t thing;  ///< Its place among the bounds.
  };

  /// @param things   all there are.
  /// @param place    [m], from where beams start, or from up to `margin` [m] away.
  /// @param max_range [m], what is farther is left out.
  BearingIndex(const std::vector<Bounds>& things, const Eigen::Vector2d& place, double margin, double max_range);

  /// Those that a beam towards `heading` (not zero) can meet, by `near`.
  const std::vector<Entry>& Towards(const Eigen::Vector2d& heading) const;

 private:
  std::vector<std::vector<Entry>> sectors_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_BEARING_INDEX_H_
