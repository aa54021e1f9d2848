#include "frontend/projection/canopy_height.h"

#include <algorithm>
#include <cstddef>

namespace arborslam {
namespace {

constexpr float kMaxRange = 15.0f;   // [m]
constexpr float kMinHeight = 0.25f;  // [m], below is ground and grass.
constexpr size_t kStride = 7;        // Every seventh return is enough; 7 shares no factor with the numbers of rings.
constexpr int kMemory = 50;          // Sweeps.

}  // namespace

void CanopyHeight::Add(const std::vector<Eigen::Vector3f>& points, const std::vector<float>& heights) {
  std::array<float, kBins> counts{};
  for (size_t i = 0; i < points.size(); i += kStride) {
    const float height = heights[i];
    if (!(height >= kMinHeight && height < kBins * kBinHeight)) continue;
    if (points[i].head<2>().squaredNorm() > kMaxRange * kMaxRange) continue;
    counts[static_cast<size_t>(height * (1.0f / kBinHeight))] += 1.0f;
  }
  num_sweeps_ = std::min(num_sweeps_ + 1, kMemory);
  const float share = 1.0f / static_cast<float>(num_sweeps_);
  for (size_t bin = 0; bin < counts.size(); ++bin) returns_[bin] += share * (counts[bin] - returns_[bin]);
}

float CanopyHeight::Get() const {
  float sum = 0.0f;
  float moment = 0.0f;
  for (size_t bin = 0; bin < returns_.size(); ++bin) {
    sum += returns_[bin];
    moment += returns_[bin] * (static_cast<float>(bin) + 0.5f) * kBinHeight;
  }
  return sum > 0.0f ? std::clamp(moment / sum, kLeast, kMost) : kInitial;
}

}  // namespace arborslam
