#include "frontend/projection/lowest_returns.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/cpu_clones.h"

namespace arborslam {

LowestReturns::LowestReturns(float cell_size, float min_range, float max_range)
    : inverse_cell_size_(1.0f / cell_size), min_range_squared_(min_range * min_range), max_range_(max_range) {
  CHECK_GT(cell_size, 0.0f);
  CHECK_GT(max_range, 0.0f);
  width_ = static_cast<int>(std::ceil(2.0f * max_range / cell_size)) + 1;
  cells_.resize(static_cast<size_t>(width_) * static_cast<size_t>(width_));
}

ARBORSLAM_CPU_CLONES const std::vector<Eigen::Vector3f>& LowestReturns::Find(const std::vector<Eigen::Vector3f>& points,
                                                                             const Eigen::Vector3f& up) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  std::fill(cells_.begin(), cells_.end(), Cell{kNone, 0});
  // In blocks: cells and heights first, which the compiler can vectorise, then the comparisons.
  constexpr size_t kBlock = 64;
  std::array<float, kBlock> x;
  std::array<float, kBlock> y;
  std::array<float, kBlock> height;
  std::array<int, kBlock> cell_of;
  const float up_x = up.x(), up_y = up.y(), up_z = up.z();
  for (size_t begin = 0; begin < points.size(); begin += kBlock) {
    const size_t size = std::min(kBlock, points.size() - begin);
    for (size_t i = 0; i < size; ++i) {
      const Eigen::Vector3f& p = points[begin + i];
      x[i] = p.x();
      y[i] = p.y();
      height[i] = p.z();
    }
    for (size_t i = 0; i < size; ++i) {
      height[i] = up_x * x[i] + up_y * y[i] + up_z * height[i];
      const float range_squared = x[i] * x[i] + y[i] * y[i];
      const float abs_x = std::abs(x[i]);
      const float abs_y = std::abs(y[i]);
      const float farther = abs_x > abs_y ? abs_x : abs_y;
      // What is not wanted goes to the cell at the centre, but never wins there.
      const float inside = farther < max_range_ ? 1.0f : 0.0f;
      height[i] = inside > 0.0f ? height[i] : kNone;
      height[i] = range_squared >= min_range_squared_ ? height[i] : kNone;
      const int column = static_cast<int>((inside * x[i] + max_range_) * inverse_cell_size_);
      const int row = static_cast<int>((inside * y[i] + max_range_) * inverse_cell_size_);
      cell_of[i] = row * width_ + column;
    }
    for (size_t i = 0; i < size; ++i) {
      Cell& cell = cells_[static_cast<size_t>(cell_of[i])];
      if (height[i] < cell.height) cell = {height[i], static_cast<uint32_t>(begin + i)};
    }
  }
  returns_.clear();
  for (const Cell& cell : cells_) {
    if (cell.height < kNone) returns_.push_back(points[cell.point]);
  }
  return returns_;
}

}  // namespace arborslam
