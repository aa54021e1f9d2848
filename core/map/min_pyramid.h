#ifndef ARBORSLAM_CORE_MAP_MIN_PYRAMID_H_
#define ARBORSLAM_CORE_MAP_MIN_PYRAMID_H_

#include <cstdint>
#include <vector>

#include "core/map/distance_field.h"
#include "core/map/free_area.h"

namespace arborslam {

/// For every cell and every window of 2^level by 2^level cells that starts there, the least distance in the window:
/// what branch and bound needs to bound a point's distance over a box of translations from below (Olson 2015; Hess et
/// al. 2016 keep maxima of probability in the same way). Distances are rounded down to `kNumSteps` steps of the
/// truncation, which keeps the bounds valid and a histogram of them small.
class MinPyramid {
 public:
  static constexpr int kNumSteps = 63;  ///< Quantised distances run from 0 to this, which means "too far".
  static constexpr int kUnseen = 64;    ///< Added to a window's distance if nobody has looked into all of it.

  /// One level: a window's least quantised distance, windows that start outside included.
  struct Level {
    int offset = 0;              ///< Windows are stored from cell (-offset, -offset) on.
    int width = 0;               ///< [windows] along x.
    int height = 0;              ///< [windows] along y.
    uint8_t beyond = kNumSteps;  ///< Of windows that lie outside.
    std::vector<uint8_t> least;

    /// Of the window that starts at cell (x, y); "too far" where no part of it lies in the field.
    uint8_t At(int x, int y) const {
      // Negative ones become great.
      const auto column = static_cast<uint32_t>(x + offset);
      const auto row = static_cast<uint32_t>(y + offset);
      if (column >= static_cast<uint32_t>(width) || row >= static_cast<uint32_t>(height)) return beyond;
      return least[static_cast<size_t>(column) * static_cast<size_t>(height) + row];
    }
  };

  /// Levels 0 to `num_levels` - 1 of `field`.
  MinPyramid(const DistanceField& field, int num_levels);
  /// The same over the field and its surroundings, that also tells what was seen: cells that are too far from
  /// everything are `kUnseen` as well unless they are free, and so is all outside.
  MinPyramid(const DistanceField& field, const FreeArea& free_area, int num_levels);

  /// Adds what is missing of levels up to `num_levels` - 1.
  void Extend(int num_levels);

  const Level& level(int index) const { return levels_[static_cast<size_t>(index)]; }
  int num_levels() const { return static_cast<int>(levels_.size()); }
  /// [m] that one quantisation step stands for.
  float metres_per_step() const { return metres_per_step_; }
  int first_x() const { return first_x_; }  ///< Cell (0, 0) is cell (first_x, first_y) of the plane.
  int first_y() const { return first_y_; }

 private:
  template <class Combine>
  void AddLevel(Combine combine);

  int first_x_;
  int first_y_;
  std::vector<Level> levels_;
  float metres_per_step_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_MIN_PYRAMID_H_
