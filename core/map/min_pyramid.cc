#include "core/map/min_pyramid.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

// [cells] around a field, as far as what is free is of interest: where the things of a place end.
constexpr int kBorder = 20;

}  // namespace

MinPyramid::MinPyramid(const DistanceField& field, int num_levels)
    : first_x_(field.first_x()),
      first_y_(field.first_y()),
      metres_per_step_(field.max_distance() / static_cast<float>(kNumSteps)) {
  CHECK_GE(num_levels, 1);
  levels_.push_back({0, field.width(), field.height(), kNumSteps, field.Quantised(kNumSteps)});
  Extend(num_levels);
}

MinPyramid::MinPyramid(const DistanceField& field, const FreeArea& free_area, int num_levels)
    : metres_per_step_(field.max_distance() / static_cast<float>(kNumSteps)) {
  CHECK_GE(num_levels, 1);
  const float cell_size = field.cell_size();
  const auto cell_of = [cell_size](float position) { return static_cast<int>(std::floor(position / cell_size)); };
  first_x_ = std::clamp(cell_of(free_area.low().x()), field.first_x() - kBorder, field.first_x());
  first_y_ = std::clamp(cell_of(free_area.low().y()), field.first_y() - kBorder, field.first_y());
  const auto end_of = [&](float high, int end) { return std::clamp(cell_of(high) + 1, end, end + kBorder); };
  const int width = end_of(free_area.high().x(), field.first_x() + field.width()) - first_x_;
  const int height = end_of(free_area.high().y(), field.first_y() + field.height()) - first_y_;
  constexpr uint8_t kNothing = kNumSteps + kUnseen;
  Level level{0, width, height, kNothing, {}};
  level.least.assign(static_cast<size_t>(width) * static_cast<size_t>(height), kNothing);
  const std::vector<uint8_t> distances = field.Quantised(kNumSteps);
  const int field_x = field.first_x() - first_x_;
  const int field_y = field.first_y() - first_y_;
  for (int x = 0; x < field.width(); ++x) {
    const auto from = distances.begin() + static_cast<ptrdiff_t>(x) * field.height();
    const auto to = level.least.begin() + static_cast<ptrdiff_t>(x + field_x) * height + field_y;
    std::transform(from, from + field.height(), to,
                   [](uint8_t distance) { return distance == kNumSteps ? kNothing : distance; });
  }
  auto cell = level.least.begin();
  for (int x = 0; x < width; ++x) {
    for (int y = 0; y < height; ++y, ++cell) {
      if (*cell != kNothing) continue;
      const Eigen::Vector2f center(static_cast<float>(first_x_ + x) + 0.5f, static_cast<float>(first_y_ + y) + 0.5f);
      if (free_area.Contains(cell_size * center)) *cell = kNumSteps;
    }
  }
  levels_.push_back(std::move(level));
  Extend(num_levels);
}

void MinPyramid::Extend(int num_levels) {
  const auto least = [](uint8_t a, uint8_t b) { return std::min(a, b); };
  const auto least_and_unseen = [](uint8_t a, uint8_t b) {
    const auto one = static_cast<uint8_t>(a & kNumSteps);
    const auto other = static_cast<uint8_t>(b & kNumSteps);
    return static_cast<uint8_t>(std::min(one, other) | ((a | b) & kUnseen));
  };
  while (this->num_levels() < num_levels) {
    if (levels_.front().beyond == kNumSteps) {
      AddLevel(least);
    } else {
      AddLevel(least_and_unseen);
    }
  }
}

template <class Combine>
void MinPyramid::AddLevel(Combine combine) {
  // A window of twice the size is made of two of the level below: what is stored at place i is that of places i - half
  // and i. First pairs are made along y, then of these along x.
  const Level& below = levels_.back();
  const int half = 1 << (num_levels() - 1);
  Level level{2 * half - 1, below.width + half, below.height + half, below.beyond, {}};
  const auto height = static_cast<size_t>(level.height);
  const auto below_height = static_cast<size_t>(below.height);
  const auto shift = static_cast<size_t>(half);
  const auto combine_into = [&combine](const uint8_t* from, size_t count, uint8_t* to) {
    for (size_t i = 0; i < count; ++i) to[i] = combine(to[i], from[i]);
  };
  const std::vector<uint8_t> outside(std::max(height, shift), below.beyond);
  std::vector<uint8_t> paired(static_cast<size_t>(below.width) * height, below.beyond);
  for (size_t x = 0; x < static_cast<size_t>(below.width); ++x) {
    const uint8_t* from = below.least.data() + x * below_height;
    uint8_t* to = paired.data() + x * height;
    std::copy_n(from, below_height, to);
    combine_into(outside.data(), shift, to);
    combine_into(from, below_height, to + shift);
  }
  level.least.reserve(static_cast<size_t>(level.width) * height);
  level.least.assign(paired.begin(), paired.end());
  level.least.resize(static_cast<size_t>(level.width) * height, below.beyond);
  for (size_t x = 0; x < static_cast<size_t>(level.width); ++x) {
    const uint8_t* before = x < shift ? outside.data() : paired.data() + (x - shift) * height;
    combine_into(before, height, level.least.data() + x * height);
  }
  levels_.push_back(std::move(level));
}

}  // namespace arborslam
