#include "frontend/projection/ground_search.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr size_t kMaxReturns = 12000;  // More are thinned evenly before they are sorted into voxels.
constexpr float kVoxel = 0.25f;        // [m]
constexpr float kFullVoxel = 3.0f;     // Returns, from which on a voxel has full weight: ghosts are mostly alone.
constexpr float kMinRange = 0.5f;      // [m]
constexpr float kMaxRange = 20.0f;     // [m]
constexpr float kNearRange = 6.0f;     // [m], within which returns have about full weight.
constexpr float kBand = 0.08f;         // [m], near range.
constexpr float kBandGrowth = 0.015f;  // [m] per m of range.
constexpr float kBelowPenalty = 0.7f;
constexpr int kDraws = 1500;
constexpr Eigen::Index kFewReturns = 300;  // By which the draws are compared first.
constexpr size_t kFinalists = 12;
constexpr int kIterations = 8;
constexpr float kFirstBand = 3.0f;  // Over kBand; the last one is 1.
constexpr Eigen::Index kMinReturns = 30;
constexpr float kMinArea = 1.0f;        // [m^2], of the triangle of a draw, times two.
constexpr float kMinShare = 0.05f;      // Of returns on the plane.
constexpr float kMaxBelowShare = 0.8f;  // Of returns below, over those on the plane.
constexpr float kMinSpread = 0.15f;     // [m], standard deviation of the returns on it along their shorter axis.
// A lidar that sees nothing but a plane through itself has one ring.
constexpr float kRingShare = 0.985f;
constexpr float kRingHeight = 0.1f;  // [m]

// normal^T p + height = 0.
struct Plane {
  Eigen::Vector3f normal;
  float height;
  float score = 0.0f;
};

// Thinned returns, with their weights.
struct Returns {
  Eigen::ArrayXf x, y, z;
  Eigen::ArrayXf weight;
  Eigen::ArrayXf inverse_band;
  float total = 0.0f;

  Eigen::Index size() const { return x.size(); }
  Eigen::Vector3f At(Eigen::Index i) const { return {x[i], y[i], z[i]}; }
};

// One return of every voxel, in a random order.
Returns Thinned(const std::vector<Eigen::Vector3f>& points, Random* random) {
  constexpr int kCells = 2 * static_cast<int>(kMaxRange / kVoxel);
  struct Entry {
    uint32_t voxel;
    uint32_t point;
    bool operator<(const Entry& other) const {
      return voxel != other.voxel ? voxel < other.voxel : point < other.point;
    }
  };
  std::vector<Entry> entries;
  const size_t stride = std::max<size_t>(1, points.size() / kMaxReturns);
  for (size_t i = 0; i < points.size(); i += stride) {
    const float range_squared = points[i].squaredNorm();
    if (!(range_squared >= kMinRange * kMinRange && range_squared < kMaxRange * kMaxRange)) continue;
    const Eigen::Vector3i cell = ((points[i].array() + kMaxRange) / kVoxel).cast<int>().min(kCells - 1).matrix();
    entries.push_back(
        {static_cast<uint32_t>((cell.z() * kCells + cell.y()) * kCells + cell.x()), static_cast<uint32_t>(i)});
  }
  std::sort(entries.begin(), entries.end());
  std::vector<std::pair<uint32_t, float>> kept;  // Point and number of returns.
  for (size_t i = 0; i < entries.size(); ++i) {
    if (i == 0 || entries[i].voxel != entries[i - 1].voxel) kept.emplace_back(entries[i].point, 0.0f);
    kept.back().second += 1.0f;
  }
  for (size_t i = kept.size(); i > 1; --i) std::swap(kept[i - 1], kept[(random->Bits() >> 32) * i >> 32]);
  Returns returns;
  const auto size = static_cast<Eigen::Index>(kept.size());
  for (Eigen::ArrayXf* array : {&returns.x, &returns.y, &returns.z, &returns.weight, &returns.inverse_band}) {
    array->resize(size);
  }
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto& [point, count] = kept[static_cast<size_t>(i)];
    const Eigen::Vector3f& p = points[point];
    const float range_squared = p.squaredNorm();
    returns.x[i] = p.x();
    returns.y[i] = p.y();
    returns.z[i] = p.z();
    returns.weight[i] = std::min(1.0f, count / kFullVoxel) / (1.0f + range_squared / (kNearRange * kNearRange));
    returns.inverse_band[i] = 1.0f / (kBand + kBandGrowth * std::sqrt(range_squared));
  }
  returns.total = returns.weight.sum();
  return returns;
}

// Distances above the plane over the band.
auto Distances(const Plane& plane, const Returns& r, Eigen::Index count) {
  return (plane.normal.x() * r.x.head(count) + plane.normal.y() * r.y.head(count) + plane.normal.z() * r.z.head(count) +
          plane.height) *
         r.inverse_band.head(count);
}

// Of the first `count` returns.
float Score(const Plane& plane, const Returns& r, Eigen::Index count, Eigen::ArrayXf* scratch) {
  *scratch = Distances(plane, r, count);
  const Eigen::ArrayXf& d = *scratch;
  return (r.weight.head(count) *
          ((1.0f - d * d).max(0.0f) - kBelowPenalty * (d.min(0.0f).square() - 1.0f).max(0.0f).min(1.0f)))
      .sum();
}

bool IsIn(const Plane& plane, const GroundSearchRegion& region) {
  const float tilt = std::acos(std::clamp(plane.normal.dot(region.up), -1.0f, 1.0f));
  return plane.height >= region.min_height && plane.height <= region.max_height && tilt >= region.min_tilt &&
         tilt <= region.max_tilt;
}

struct Spread {
  Eigen::Vector3f mean;
  Eigen::Vector3f variances;  // [m^2], ascending.
  Eigen::Vector3f normal;     // The axis of the least variance.
};

Spread SpreadOf(const Returns& r, const Eigen::ArrayXf& weight) {
  const float sum = weight.sum() + 1e-9f;
  Spread spread;
  spread.mean = Eigen::Vector3f((weight * r.x).sum(), (weight * r.y).sum(), (weight * r.z).sum()) / sum;
  const Eigen::ArrayXf x = r.x - spread.mean.x();
  const Eigen::ArrayXf y = r.y - spread.mean.y();
  const Eigen::ArrayXf z = r.z - spread.mean.z();
  const float xy = (weight * x * y).sum();
  const float xz = (weight * x * z).sum();
  const float yz = (weight * y * z).sum();
  Eigen::Matrix3f moment;
  moment << (weight * x * x).sum(), xy, xz,  //
      xy, (weight * y * y).sum(), yz,        //
      xz, yz, (weight * z * z).sum();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver(moment / sum);
  spread.variances = solver.eigenvalues();
  spread.normal = solver.eigenvectors().col(0);
  return spread;
}

Plane Refined(Plane plane, const Returns& r) {
  for (int i = 0; i < kIterations; ++i) {
    const float band = std::pow(kFirstBand, 1.0f - static_cast<float>(i) / (kIterations - 1));
    const Eigen::ArrayXf d = Distances(plane, r, r.size()) / band;
    const Spread spread = SpreadOf(r, r.weight * r.inverse_band.square() * (1.0f - d.square()).max(0.0f).square());
    plane.normal = spread.normal.dot(plane.normal) < 0.0f ? Eigen::Vector3f(-spread.normal) : spread.normal;
    plane.height = -plane.normal.dot(spread.mean);
  }
  return plane;
}

}  // namespace

GroundPlane SearchGround(const std::vector<Eigen::Vector3f>& points, const GroundSearchRegion& region) {
  GroundPlane ground;
  Random random(1);
  const Returns returns = Thinned(points, &random);
  if (returns.size() < kMinReturns) return ground;
  const Eigen::Index few = std::min(kFewReturns, returns.size());
  Eigen::ArrayXf scratch;
  const auto draw = [&] {
    return returns.At(static_cast<Eigen::Index>((random.Bits() >> 32) * static_cast<uint64_t>(returns.size()) >> 32));
  };
  std::vector<Plane> planes;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3f a = draw();
    const Eigen::Vector3f b = draw();
    const Eigen::Vector3f n = (b - a).cross(draw() - a);
    const float area = n.norm();
    if (!(area > kMinArea)) continue;
    for (const float sign : {1.0f, -1.0f}) {
      Plane plane{n * (sign / area), 0.0f};
      plane.height = -plane.normal.dot(a);
      if (!IsIn(plane, region)) continue;
      plane.score = Score(plane, returns, few, &scratch);
      if (plane.score > 0.0f) planes.push_back(plane);
    }
  }
  const auto is_better = [](const Plane& a, const Plane& b) { return a.score > b.score; };
  std::stable_sort(planes.begin(), planes.end(), is_better);
  planes.resize(std::min(planes.size(), kFinalists));
  Plane best{Eigen::Vector3f::UnitZ(), 0.0f};
  for (const Plane& drawn : planes) {
    Plane plane = Refined(drawn, returns);
    if (!IsIn(plane, region)) continue;
    plane.score = Score(plane, returns, returns.size(), &scratch);
    if (plane.score > best.score) best = plane;
  }
  if (best.score <= 0.0f) return ground;

  const Eigen::ArrayXf distances = Distances(best, returns, returns.size());
  const Eigen::ArrayXf on_plane = returns.weight * (distances.abs() < 1.0f).cast<float>();
  ground.normal = best.normal;
  ground.height = best.height;
  ground.score = best.score / returns.total;
  ground.share = on_plane.sum() / returns.total;
  ground.share_below = (returns.weight * (distances < -1.0f).cast<float>()).sum() / returns.total;
  const bool is_ring = ground.share > kRingShare && std::abs(ground.height) < kRingHeight;
  ground.ok = !is_ring && ground.share >= kMinShare && ground.share_below <= kMaxBelowShare * ground.share &&
              SpreadOf(returns, on_plane).variances.y() >= kMinSpread * kMinSpread;
  return ground;
}

}  // namespace arborslam
