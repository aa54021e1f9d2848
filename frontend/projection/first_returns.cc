#include "frontend/projection/first_returns.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"

namespace arborslam {
namespace {

constexpr float kSectorsPerRadian = 57.29578f;
// [sectors], no farther to the sides is looked, however near a place is.
constexpr int kMaxReach = 30;

int SectorOf(const Eigen::Vector2f& direction) {
  const float turn = FastAtan2(direction.y(), direction.x()) + static_cast<float>(kPi);
  return static_cast<int>(turn * kSectorsPerRadian);
}

}  // namespace

FirstReturns::FirstReturns(const PlanarScan& scan) {
  first_.fill(std::numeric_limits<float>::infinity());
  free_.fill(0.0f);
  const auto sector_of = [](const Eigen::Vector2f& place) {
    return static_cast<size_t>(std::min(SectorOf(place), kSectors - 1));
  };
  for (const auto* returns : {&scan.points, &scan.first_returns}) {
    for (const Eigen::Vector2f& point : *returns) {
      float& first = first_[sector_of(point)];
      first = std::min(first, point.norm());
    }
  }
  for (const Eigen::Vector2f& end : scan.free_ends) {
    float& range = free_[sector_of(end)];
    range = std::max(range, end.norm());
  }
  for (size_t i = 0; i < kSectors; ++i) {
    if (std::isfinite(first_[i])) free_[i] = first_[i];
  }
}

Sight FirstReturns::Look(const Eigen::Vector2f& place, float range_margin, float side_margin) const {
  const int sector = std::min(SectorOf(place), kSectors - 1);
  const float distance = place.norm();
  const int reach =
      static_cast<int>(std::min(std::ceil(kSectorsPerRadian * side_margin / distance), static_cast<float>(kMaxReach)));
  float nearest = first_[static_cast<size_t>(sector)];
  for (int i = sector - reach; i <= sector + reach; ++i) {
    nearest = std::min(nearest, first_[static_cast<size_t>(i < 0 ? i + kSectors : i >= kSectors ? i - kSectors : i)]);
  }
  if (nearest < distance - range_margin) return Sight::kHidden;
  if (nearest <= distance + range_margin) return Sight::kOccupied;
  return free_[static_cast<size_t>(sector)] > distance ? Sight::kFree : Sight::kUnknown;
}

}  // namespace arborslam
