#include "frontend/projection/lowest_returns.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace arborslam {

LowestReturns::LowestReturns(float cell_size, float min_range, float max_range)
    : inverse_cell_size_(1.0f / cell_size), min_range_squared_(min_range * min_range), max_range_(max_range) {
  CHECK_GT(cell_size, 0.0f);
  CHECK_GT(max_range, 0.0f);
  width_ = static_cast<int>(std::ceil(2.0f * max_range / cell_size)) + 1;
  cells_.resize(static_cast<size_t>(width_) * static_cast<size_t>(width_));
}

const std::vector<Eigen::Vector3f>& LowestReturns::Find(const std::vector<Eigen::Vector3f>& points,
                                                        const Eigen::Vector3f& up) {
  constexpr float kNone = std::numeric_limits<float>::infinity();
  std::fill(cells_.begin(), cells_.end(), Cell{kNone, 0});
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& p = points[i];
    if (!(std::abs(p.x()) < max_range_ && std::abs(p.y()) < max_range_)) continue;
    if (p.x() * p.x() + p.y() * p.y() < min_range_squared_) continue;
    const int x = static_cast<int>((p.x() + max_range_) * inverse_cell_size_);
    const int y = static_cast<int>((p.y() + max_range_) * inverse_cell_size_);
    Cell& cell = cells_[static_cast<size_t>(y * width_ + x)];
    const float height = up.dot(p);
    if (height < cell.height) cell = {height, static_cast<uint32_t>(i)};
  }
  returns_.clear();
  for (const Cell& cell : cells_) {
    if (cell.height < kNone) returns_.push_back(points[cell.point]);
  }
  return returns_;
}

}  // namespace arborslam
