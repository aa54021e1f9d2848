#ifndef ARBORSLAM_CORE_MAP_MIN_PYRAMID_H_
#define ARBORSLAM_CORE_MAP_MIN_PYRAMID_H_

#include <cstdint>
#include <vector>

#include "core/map/distance_field.h"

namespace arborslam {

/// For every cell and every window of 2^level by 2^level cells that starts there, the least distance in the window:
/// what branch and bound needs to bound a point's distance over a box of translations from below (Olson 2015; Hess et
/// al. 2016 keep maxima of probability in the same way). Distances are rounded down to `kNumSteps` steps of the
/// truncation, which keeps the bounds valid and a histogram of them small.
class MinPyramid {
 public:
  static constexpr int kNumSteps = 63;  ///< Quantised distances run from 0 to this, which means "too far".

  /// One level: a window's least quantised distance, windows that start outside the field included.
  struct Level {
    int offset = 0;  ///< Windows are stored from cell (-offset, -offset) of the field on.
    int width = 0;   ///< [windows] along x.
    int height = 0;  ///< [windows] along y.
    std::vector<uint8_t> least;

    /// Of the window that starts at cell (x, y) of the field; "too far" where no part of it lies in the field.
    uint8_t At(int x, int y) const {
      const int column = x + offset;
      const int row = y + offset;
      if (column < 0 || row < 0 || column >= width || row >= height) return kNumSteps;
      return least[static_cast<size_t>(column) * static_cast<size_t>(height) + static_cast<size_t>(row)];
    }
  };

  /// Levels 0 to `num_levels` - 1 of `field`.
  MinPyramid(const DistanceField& field, int num_levels);

  /// Adds what is missing of levels up to `num_levels` - 1.
  void Extend(int num_levels);

  const Level& level(int index) const { return levels_[static_cast<size_t>(index)]; }
  int num_levels() const { return static_cast<int>(levels_.size()); }
  /// [m] that one quantisation step stands for.
  float metres_per_step() const { return metres_per_step_; }

 private:
  std::vector<Level> levels_;
  float metres_per_step_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_MIN_PYRAMID_H_
