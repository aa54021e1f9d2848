#include "backend/loop/place_descriptor.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr int kRings = PlaceDescriptor::kNumRings;
constexpr int kSectors = PlaceDescriptor::kNumSectors;
// So many points fill a bin: a trunk's visible side.
constexpr float kFullBin = 6.0f;
// Of a bin's value, what spills over to the four bins beside it and to the four at its corners.
constexpr float kSpillBeside = 0.6f;
constexpr float kSpillAcross = 0.35f;

}  // namespace

PlaceDescriptor DescribePlace(const std::vector<Eigen::Vector2f>& points, double max_range) {
  PlaceDescriptor::Bins filled = PlaceDescriptor::Bins::Zero();
  for (const Eigen::Vector2f& point : points) {
    const double range = point.norm();
    if (!(range < max_range)) continue;
    const int ring = std::min(kRings - 1, static_cast<int>(range / max_range * kRings));
    const double bearing = std::atan2(point.y(), point.x());
    const int sector = static_cast<int>((bearing + kPi) / PlaceDescriptor::kSectorWidth);
    filled(ring, sector % kSectors) += 1.0f / kFullBin;
  }
  filled = filled.cwiseMin(1.0f).cwiseSqrt();

  PlaceDescriptor place;
  for (int sector = 0; sector < kSectors; ++sector) {
    for (int ring = 0; ring < kRings; ++ring) {
      float most = filled(ring, sector);
      for (int d_ring = -1; d_ring <= 1; ++d_ring) {
        if (ring + d_ring < 0 || ring + d_ring >= kRings) continue;
        for (int d_sector = -1; d_sector <= 1; ++d_sector) {
          if (d_ring == 0 && d_sector == 0) continue;
          const float spill = d_ring != 0 && d_sector != 0 ? kSpillAcross : kSpillBeside;
          most = std::max(most, spill * filled(ring + d_ring, (sector + d_sector + kSectors) % kSectors));
        }
      }
      place.bins(ring, sector) = most;
    }
  }
  const float norm = place.bins.norm();
  if (norm > 0.0f) place.bins /= norm;
  place.ring_key = place.bins.rowwise().mean();
  return place;
}

PlaceSimilarity ComparePlaces(const PlaceDescriptor& query, const PlaceDescriptor& place) {
  // Sectors are contiguous: a turn compares two stretches of each.
  constexpr int kSize = kRings * kSectors;
  const Eigen::Map<const Eigen::VectorXf> a(query.bins.data(), kSize);
  const Eigen::Map<const Eigen::VectorXf> b(place.bins.data(), kSize);
  float most = 0.0f;
  int turn = 0;
  for (int sectors = 0; sectors < kSectors; ++sectors) {
    const int shift = sectors * kRings;
    const float product = a.head(kSize - shift).dot(b.tail(kSize - shift)) + a.tail(shift).dot(b.head(shift));
    if (product <= most) continue;
    most = product;
    turn = sectors;
  }
  return {most, NormalizeAngle(turn * PlaceDescriptor::kSectorWidth)};
}

}  // namespace arborslam
