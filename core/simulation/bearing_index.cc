#include "core/simulation/bearing_index.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr int kNumSectors = 720;
constexpr double kSectorsPerRadian = kNumSectors / (2.0 * kPi);

}  // namespace

Bounds BoundsOf(const Frustum& frustum) {
  const Eigen::Vector3d extent = frustum.length * frustum.axis;
  const Eigen::Vector3d middle = frustum.base + 0.5 * extent;
  const double radius = std::max(frustum.base_radius, frustum.top_radius);
  const double top = middle.z() + 0.5 * std::abs(extent.z()) + radius;
  return {middle.head<2>(), 0.5 * extent.head<2>().norm() + radius, middle.z() - 0.5 * std::abs(extent.z()) - radius,
          top};
}

Bounds BoundsOf(const Leaves& leaves) {
  const double radius = leaves.shape == Leaves::Shape::kBox ? leaves.extent.head<2>().norm()
                                                            : std::max(leaves.extent.x(), leaves.extent.y());
  return {leaves.center.head<2>(), radius, leaves.center.z() - leaves.extent.z(),
          leaves.center.z() + leaves.extent.z()};
}

BearingIndex::BearingIndex(const std::vector<Bounds>& things, const Eigen::Vector2d& place, double margin,
                           double max_range)
    : sectors_(kNumSectors) {
  struct Sight {
    Entry entry;
    double bearing;
    double half_width;
  };
  std::vector<Sight> sights;
  for (size_t i = 0; i < things.size(); ++i) {
    const Eigen::Vector2d offset = things[i].center - place;
    const double radius = things[i].radius + margin;
    const double reach = max_range + radius;
    if (offset.squaredNorm() > reach * reach) continue;
    const double distance = offset.norm();
    const double half_width = distance > radius ? std::asin(radius / distance) : kPi;
    const Entry entry{static_cast<float>(std::max(0.0, distance - radius)), static_cast<float>(distance + radius),
                      static_cast<float>(things[i].low), static_cast<float>(things[i].high), static_cast<uint32_t>(i)};
    sights.push_back({entry, std::atan2(offset.y(), offset.x()), half_width});
  }
  std::sort(sights.begin(), sights.end(), [](const Sight& a, const Sight& b) {
    return a.entry.near < b.entry.near || (a.entry.near == b.entry.near && a.entry.thing < b.entry.thing);
  });
  for (const Sight& sight : sights) {
    const int first = static_cast<int>(std::floor((sight.bearing - sight.half_width + kPi) * kSectorsPerRadian));
    const int last = static_cast<int>(std::floor((sight.bearing + sight.half_width + kPi) * kSectorsPerRadian));
    for (int i = first; i <= std::min(last, first + kNumSectors - 1); ++i) {
      sectors_[static_cast<size_t>((i + kNumSectors) % kNumSectors)].push_back(sight.entry);
    }
  }
}

const std::vector<BearingIndex::Entry>& BearingIndex::Towards(const Eigen::Vector2d& heading) const {
  const double bearing = std::atan2(heading.y(), heading.x());
  const int sector = static_cast<int>(std::floor((bearing + kPi) * kSectorsPerRadian));
  return sectors_[static_cast<size_t>(std::clamp(sector, 0, kNumSectors - 1))];
}

}  // namespace arborslam
