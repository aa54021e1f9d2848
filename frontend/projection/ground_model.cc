#include "frontend/projection/ground_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace arborslam {
namespace {

constexpr float kSmoothness = 0.5f;  // Weight of a neighbour against that of a full node.
constexpr float kFlatness = 0.02f;   // Weight of the plane.
constexpr int kIterations = 12;
constexpr float kFirstMargin = 0.15f;  // [m], plus kFirstSlope of the range: so far above the plane may ground be.
constexpr float kFirstSlope = 0.06f;
constexpr float kLastMargin = 0.12f;  // [m], over the neighbours.
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
      sums_(kSampleCells * kSampleCells) {}

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
          const float range =
              kNodeSpacing * std::hypot(static_cast<float>(x - kNodes / 2), static_cast<float>(y - kNodes / 2));
          const float limit =
              iteration < kIterations / 2 ? kFirstMargin + kFirstSlope * range : around + kLastMargin + 0.01f * range;
          if (nodes_[i].low > limit) weight = 0.0f;
        }
        heights_[i] = (weight * nodes_[i].low + kSmoothness * sum) / (weight + kSmoothness * count + kFlatness);
      }
    }
  }
}

float GroundModel::HeightAt(float x, float y) const {
  constexpr float kLast = static_cast<float>(kNodes - 1) - 1e-3f;
  const float u = std::min(std::max((x + kReach) * (1.0f / kNodeSpacing), 0.0f), kLast);
  const float v = std::min(std::max((y + kReach) * (1.0f / kNodeSpacing), 0.0f), kLast);
  const auto column = static_cast<int>(u);
  const auto row = static_cast<int>(v);
  const float right = u - static_cast<float>(column);
  const float upper = v - static_cast<float>(row);
  const float* const node = &heights_[static_cast<size_t>(row * kNodes + column)];
  const float low = node[0] + right * (node[1] - node[0]);
  const float high = node[kNodes] + right * (node[kNodes + 1] - node[kNodes]);
  return low + upper * (high - low);
}

void GroundModel::Measure(const std::vector<Eigen::Vector3f>& points, std::vector<float>* heights) {
  heights->resize(points.size());
  std::fill(sums_.begin(), sums_.end(), Eigen::Vector4f::Zero());
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = rotation_ * points[i];
    const float height = p.z() + lidar_height_ - HeightAt(p.x(), p.y());
    (*heights)[i] = height;
    if (height > 0.2f || std::abs(p.x()) >= kReach || std::abs(p.y()) >= kReach) continue;
    const float range_squared = p.x() * p.x() + p.y() * p.y();
    if (range_squared < kMinSampleRange * kMinSampleRange) continue;
    if (std::abs(height) > kGroundBand + kGroundGrowth * std::sqrt(range_squared)) continue;
    const auto x = static_cast<int>(p.x() + kReach);
    const auto y = static_cast<int>(p.y() + kReach);
    Eigen::Vector4f& sum = sums_[static_cast<size_t>(y * kSampleCells + x)];
    sum.head<3>() += points[i];
    sum.w() += 1.0f;
  }
  samples_.clear();
  for (const Eigen::Vector4f& sum : sums_) {
    if (sum.w() >= kMinSampleCount) samples_.push_back({sum.head<3>() / sum.w(), sum.w()});
  }
}

}  // namespace arborslam
