#include "frontend/projection/ground_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

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
    : nodes_(kNodes * kNodes),
      heights_(kNodes * kNodes),
      returns_(kNodes * kNodes),
      sums_(kSampleCells * kSampleCells) {
  for (int y = 0; y < kNodes; ++y) {
    for (int x = 0; x < kNodes; ++x) {
      node_ranges_.push_back(kNodeSpacing *
                             std::hypot(static_cast<float>(x - kNodes / 2), static_cast<float>(y - kNodes / 2)));
    }
  }
}

void GroundModel::Build(const std::vector<Eigen::Vector3f>& lowest_returns, const GroundFit& fit) {
  rotation_ = LevelRotation(fit.normal);
  lidar_height_ = fit.height;
  for (std::vector<float>& returns : returns_) returns.clear();
  std::fill(heights_.begin(), heights_.end(), 0.0f);
  for (const Eigen::Vector3f& point : lowest_returns) {
    const Eigen::Vector3f p = rotation_ * point;
    const auto x = static_cast<int>(std::floor((p.x() + kReach) / kNodeSpacing + 0.5f));
    const auto y = static_cast<int>(std::floor((p.y() + kReach) / kNodeSpacing + 0.5f));
    if (x < 0 || y < 0 || x >= kNodes || y >= kNodes) continue;
    returns_[static_cast<size_t>(y * kNodes + x)].push_back(p.z() + lidar_height_);
  }
  for (size_t i = 0; i < nodes_.size(); ++i) {
    std::vector<float>& returns = returns_[i];
    if (returns.empty()) {
      nodes_[i] = {};
      continue;
    }
    const size_t quarter = returns.size() / 4;
    std::nth_element(returns.begin(), returns.begin() + static_cast<ptrdiff_t>(quarter), returns.end());
    nodes_[i] = {returns[quarter], std::min(1.0f, 0.25f * static_cast<float>(returns.size()))};
  }
  // Gauss and Seidel's iteration; what lies too far above the surroundings is left out, the closer the longer.
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (int y = 0; y < kNodes; ++y) {
      for (int x = 0; x < kNodes; ++x) {
        const auto i = static_cast<size_t>(y * kNodes + x);
        float sum = 0.0f;
        float count = 0.0f;
        if (x > 0) sum += heights_[i - 1], count += 1.0f;
        if (x + 1 < kNodes) sum += heights_[i + 1], count += 1.0f;
        if (y > 0) sum += heights_[i - kNodes], count += 1.0f;
        if (y + 1 < kNodes) sum += heights_[i + kNodes], count += 1.0f;
        const float around = sum / count;
        float weight = nodes_[i].weight;
        if (weight > 0.0f) {
          const float limit = iteration < kIterations / 2 ? kFirstMargin + kFirstSlope * node_ranges_[i]
                                                          : around + kLastMargin + kLastSlope * node_ranges_[i];
          if (nodes_[i].low > limit) weight = 0.0f;
        }
        heights_[i] = (weight * nodes_[i].low + kSmoothness * sum) / (weight + kSmoothness * count + kFlatness);
      }
    }
  }
}

float GroundModel::ToNodes(float coordinate) {
  constexpr float kLast = static_cast<float>(kNodes - 1) - 1e-3f;
  return std::min(std::max((coordinate + kReach) * (1.0f / kNodeSpacing), 0.0f), kLast);
}

float GroundModel::Interpolate(const float* node, float u, float v) {
  const float low = node[0] + u * (node[1] - node[0]);
  const float high = node[kNodes] + u * (node[kNodes + 1] - node[kNodes]);
  return low + v * (high - low);
}

float GroundModel::HeightAt(float x, float y) const {
  const float u = ToNodes(x);
  const float v = ToNodes(y);
  const int column = static_cast<int>(u);
  const int row = static_cast<int>(v);
  return Interpolate(&heights_[static_cast<size_t>(row * kNodes + column)], u - static_cast<float>(column),
                     v - static_cast<float>(row));
}

void GroundModel::Measure(const std::vector<Eigen::Vector3f>& points, std::vector<float>* heights) {
  heights->resize(points.size());
  std::fill(sums_.begin(), sums_.end(), Eigen::Vector4f::Zero());
  // In blocks: first what the compiler can vectorise.
  constexpr size_t kBlock = 64;
  std::array<float, kBlock> x;
  std::array<float, kBlock> y;
  std::array<float, kBlock> z;
  std::array<float, kBlock> u;
  std::array<float, kBlock> v;
  std::array<float, kBlock> above_band;
  std::array<int, kBlock> node_of;
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
      const int column = static_cast<int>(u[i]);
      const int row = static_cast<int>(v[i]);
      u[i] -= static_cast<float>(column);
      v[i] -= static_cast<float>(row);
      node_of[i] = row * kNodes + column;
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
    for (size_t i = 0; i < size; ++i) {
      if (above_band[i] > 0.0f) continue;
      // Just below the border the sum is rounded up to it.
      const int column = std::min(kSampleCells - 1, static_cast<int>(x[i] + kReach));
      const int row = std::min(kSampleCells - 1, static_cast<int>(y[i] + kReach));
      Eigen::Vector4f& sum = sums_[static_cast<size_t>(row * kSampleCells + column)];
      const Eigen::Vector3f& p = points[begin + i];
      sum += Eigen::Vector4f(p.x(), p.y(), p.z(), 1.0f);
    }
  }
  samples_.clear();
  for (const Eigen::Vector4f& sum : sums_) {
    if (sum.w() >= kMinSampleCount) samples_.push_back({sum.head<3>() / sum.w(), sum.w()});
  }
}

}  // namespace arborslam
