#include "core/map/min_pyramid.h"

#include <glog/logging.h>

#include <algorithm>

namespace arborslam {

MinPyramid::MinPyramid(const DistanceField& field, int num_levels)
    : metres_per_step_(field.max_distance() / static_cast<float>(kNumSteps)) {
  CHECK_GE(num_levels, 1);
  levels_.push_back({0, field.width(), field.height(), field.Quantised(kNumSteps)});
  Extend(num_levels);
}

void MinPyramid::Extend(int num_levels) {
  const int num_before = this->num_levels();
  if (num_levels <= num_before) return;
  levels_.resize(static_cast<size_t>(num_levels));
  // A window of twice the size is made of two pairs of the level below: first paired along y, then along x.
  std::vector<uint8_t> paired;
  for (int i = num_before; i < num_levels; ++i) {
    const Level& below = levels_[static_cast<size_t>(i) - 1];
    const int half = 1 << (i - 1);
    Level& level = levels_[static_cast<size_t>(i)];
    level.offset = (1 << i) - 1;
    level.width = below.width + half;
    level.height = below.height + half;
    const auto height = static_cast<size_t>(level.height);
    const auto below_height = static_cast<size_t>(below.height);
    const auto shift = static_cast<size_t>(half);
    paired.assign(static_cast<size_t>(below.width) * height, kNumSteps);
    for (size_t x = 0; x < static_cast<size_t>(below.width); ++x) {
      const uint8_t* from = below.least.data() + x * below_height;
      uint8_t* to = paired.data() + x * height;
      // The window at row r of this level starts `half` rows before row r of the level below, and ends with that one.
      std::copy_n(from, below_height, to);
      for (size_t y = 0; y < below_height; ++y) to[y + shift] = std::min(to[y + shift], from[y]);
    }
    level.least.assign(static_cast<size_t>(level.width) * height, kNumSteps);
    for (size_t x = 0; x < static_cast<size_t>(below.width); ++x) {
      const uint8_t* from = paired.data() + x * height;
      uint8_t* first = level.least.data() + x * height;
      uint8_t* second = level.least.data() + (x + shift) * height;
      for (size_t y = 0; y < height; ++y) first[y] = std::min(first[y], from[y]);
      for (size_t y = 0; y < height; ++y) second[y] = std::min(second[y], from[y]);
    }
  }
}

}  // namespace arborslam
