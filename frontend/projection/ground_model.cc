#include "frontend/projection/ground_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/cpu_clones.h"

namespace arborslam {
namespace {

constexpr float kSmoothness = 0.25f;  // Weight of a neighbour against that of a full node.
constexpr float kFlatness = 0.02f;    // Weight of the plane.
constexpr int kIterations = 12;
constexpr float kFirstMargin = 0.15f;  // [m], plus kFirstSlope of the range: so far above the plane may ground be.
constexpr float kFirstSlope = 0.06f;
constexpr float kLastMargin = 0.08f;  // [m], over the neighbours.
constexpr float kLastSlope = 0.01f;
constexpr float kGroundBand = 0.07f;  // [m], plus kGroundGrowth of the range.
constexpr float kGroundGrowth = 0.004f;
constexpr float kMinSampleRange = 0.5f;  // [m]
constexpr float kMinSampleCount = 3.0f;

}  // namespace

Eigen::Matrix3f LevelRotation(const Eigen::Vector3f& normal) {
  Eigen::Matrix3f rotation;
  const Eigen::Vector3f left = normal.cross(Eigen::Vector3f::UnitX()).normalized();
  rotation.row(0) = left.cross(normal);
  rotation.row(1) = left;
  rotation.row(2) = normal;
  return rotation;
}

GroundModel::GroundModel()
    : heights_(kStride * kStride),
      lows_(kStride * kStride),
      pulls_(kStride * kStride),
      shares_(kStride * kStride),
      shares_alone_(kStride * kStride),
      ranges_(kStride * kStride),
      num_neighbours_(kStride * kStride),
      returns_(kStride * kStride) {
  const auto num_sides = [](int i) { return i == 0 || i == kNodes - 1 ? 1.0f : 2.0f; };
  for (int y = 0; y < kNodes; ++y) {
    for (int x = 0; x < kNodes; ++x) {
      const size_t i = NodeAt(x, y);
      ranges_[i] = kNodeSpacing * std::hypot(static_cast<float>(x - kNodes / 2), static_cast<float>(y - kNodes / 2));
      num_neighbours_[i] = num_sides(x) + num_sides(y);
      shares_alone_[i] = kSmoothness / (kSmoothness * num_neighbours_[i] + kFlatness);
    }
  }
}

void GroundModel::Build(const std::vector<Eigen::Vector3f>& lowest_returns, const GroundFit& fit) {
  rotation_ = LevelRotation(fit.normal);
  lidar_height_ = fit.height;
  for (std::vector<float>& returns : returns_) returns.clear();
  for (const Eigen::Vector3f& point : lowest_returns) {
    const Eigen::Vector3f p = rotation_ * point;
    const auto x = static_cast<int>(std::floor((p.x() + kReach) / kNodeSpacing + 0.5f));
    const auto y = static_cast<int>(std::floor((p.y() + kReach) / kNodeSpacing + 0.5f));
    if (x < 0 || y < 0 || x >= kNodes || y >= kNodes) continue;
    returns_[NodeAt(x, y)].push_back(p.z() + lidar_height_);
  }
  lows_.assign(lows_.size(), 0.0f);
  pulls_.assign(pulls_.size(), 0.0f);
  shares_ = shares_alone_;
  for (size_t i = 0; i < returns_.size(); ++i) {
    std::vector<float>& returns = returns_[i];
    if (returns.empty()) continue;
    const size_t quarter = returns.size() / 4;
    std::nth_element(returns.begin(), returns.begin() + static_cast<ptrdiff_t>(quarter), returns.end());
    const float weight = std::min(1.0f, 0.25f * static_cast<float>(returns.size()));
    const float total = weight + kSmoothness * num_neighbours_[i] + kFlatness;
    lows_[i] = returns[quarter];
    pulls_[i] = weight * lows_[i] / total;
    shares_[i] = kSmoothness / total;
  }
  Smooth();
}

ARBORSLAM_CPU_CLONES void GroundModel::Smooth() {
  heights_.assign(heights_.size(), 0.0f);
  // Along a row all at once, by Jacobi's iteration, from row to row by Gauss and Seidel's. What lies too far above the
  // surroundings is left out, the closer the longer.
  std::array<float, kNodes> row;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const float slope = iteration < kIterations / 2 ? kFirstSlope : kLastSlope;
    const float margin = iteration < kIterations / 2 ? kFirstMargin : kLastMargin;
    const float around_counts = iteration < kIterations / 2 ? 0.0f : 1.0f;
    for (int y = 0; y < kNodes; ++y) {
      const size_t begin = NodeAt(0, y);
      for (size_t x = 0; x < kNodes; ++x) {
        const size_t i = begin + x;
        const float sum = (heights_[i - 1] + heights_[i + 1]) + (heights_[i - kStride] + heights_[i + kStride]);
        const float over = (lows_[i] - margin - slope * ranges_[i]) * num_neighbours_[i] - around_counts * sum;
        const float alone = shares_alone_[i] * sum;
        const float held = pulls_[i] + shares_[i] * sum;
        row[x] = over > 0.0f ? alone : held;
      }
      std::copy(row.begin(), row.end(), heights_.begin() + static_cast<ptrdiff_t>(begin));
    }
  }
}

float GroundModel::ToNodes(float coordinate) {
  constexpr float kLast = static_cast<float>(kNodes - 1) - 1e-3f;
  return std::min(std::max((coordinate + kReach) * (1.0f / kNodeSpacing), 0.0f), kLast);
}

float GroundModel::Interpolate(const float* node, float u, float v) {
  const float low = node[0] + u * (node[1] - node[0]);
  const float high = node[kStride] + u * (node[kStride + 1] - node[kStride]);
  return low + v * (high - low);
}

float GroundModel::HeightAt(float x, float y) const {
  const float u = ToNodes(x);
  const float v = ToNodes(y);
  const int column = static_cast<int>(u);
  const int row = static_cast<int>(v);
  return Interpolate(&heights_[NodeAt(column, row)], u - static_cast<float>(column), v - static_cast<float>(row));
}

ARBORSLAM_CPU_CLONES void GroundModel::Measure(const std::vector<Eigen::Vector3f>& points,
                                               std::vector<float>* heights) {
  heights->resize(points.size());
  for (auto& sums : sums_) sums.assign(kSampleCells * kSampleCells, Quadruple{});
  // In blocks: first what the compiler can vectorise.
  constexpr size_t kBlock = 64;
  std::array<float, kBlock> x;
  std::array<float, kBlock> y;
  std::array<float, kBlock> z;
  std::array<float, kBlock> u;
  std::array<float, kBlock> v;
  std::array<float, kBlock> above_band;
  std::array<int, kBlock> node_of;
  std::array<int, kBlock> cell_of;
  const Eigen::Matrix3f r = rotation_;
  for (size_t begin = 0; begin < points.size(); begin += kBlock) {
    const size_t size = std::min(kBlock, points.size() - begin);
    for (size_t i = 0; i < size; ++i) {
      const Eigen::Vector3f& p = points[begin + i];
      x[i] = p.x();
      y[i] = p.y();
      z[i] = p.z();
    }
    for (size_t i = 0; i < size; ++i) {
      const float level_x = r(0, 0) * x[i] + r(0, 1) * y[i] + r(0, 2) * z[i];
      const float level_y = r(1, 0) * x[i] + r(1, 1) * y[i] + r(1, 2) * z[i];
      z[i] = r(2, 0) * x[i] + r(2, 1) * y[i] + r(2, 2) * z[i] + lidar_height_;
      x[i] = level_x;
      y[i] = level_y;
      u[i] = ToNodes(level_x);
      v[i] = ToNodes(level_y);
      // Of those that are out of reach, none is asked for its cell.
      cell_of[i] = static_cast<int>(v[i] * kNodeSpacing) * kSampleCells + static_cast<int>(u[i] * kNodeSpacing);
      const int column = static_cast<int>(u[i]);
      const int row = static_cast<int>(v[i]);
      u[i] -= static_cast<float>(column);
      v[i] -= static_cast<float>(row);
      node_of[i] = (row + 1) * kStride + column + 1;
    }
    float* const height = heights->data() + begin;
    for (size_t i = 0; i < size; ++i) {
      height[i] = z[i] - Interpolate(&heights_[static_cast<size_t>(node_of[i])], u[i], v[i]);
    }
    for (size_t i = 0; i < size; ++i) {
      const float range_squared = x[i] * x[i] + y[i] * y[i];
      const float abs_x = std::abs(x[i]);
      const float abs_y = std::abs(y[i]);
      const float farther = abs_x > abs_y ? abs_x : abs_y;
      const float band = kGroundBand + kGroundGrowth * std::sqrt(range_squared);
      float above = std::abs(height[i]) - band;
      above = farther < kReach ? above : 1.0f;
      above_band[i] = range_squared >= kMinSampleRange * kMinSampleRange ? above : 1.0f;
    }
    // By turns to one of two sums: neighbours in a ring mostly lie in one cell, and would wait for one another.
    for (size_t i = 0; i < size; ++i) {
      if (above_band[i] > 0.0f) continue;
      const Eigen::Vector3f& p = points[begin + i];
      Quadruple& sum = sums_[i % 2][static_cast<size_t>(cell_of[i])];
      sum += Quadruple{p.x(), p.y(), p.z(), 1.0f};
    }
  }
  samples_.clear();
  for (size_t cell = 0; cell < sums_[0].size(); ++cell) {
    const Quadruple sum = sums_[0][cell] + sums_[1][cell];
    if (sum[3] >= kMinSampleCount) samples_.push_back({Eigen::Vector3f(sum[0], sum[1], sum[2]) / sum[3], sum[3]});
  }
}

}  // namespace arborslam
