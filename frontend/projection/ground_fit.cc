#include "frontend/projection/ground_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr float kMaxRange = 12.0f;         // [m], farther ground is not this plane;
constexpr float kMaxRangeHigh = 18.0f;     // [m], that of a lidar high above it,
constexpr float kRangePerHeight = 5.0f;    // times its height.
constexpr float kNearShare = 1.0f / 3.0f;  // Of that range, within which the ground has about full weight.
constexpr float kMinHeight = 0.1f;         // [m], of the lidar.
constexpr float kMaxHeight = 5.5f;         // [m], of the lidar.
constexpr float kMinUp = 0.88f;            // z of the normal, about 28 deg of tilt.
constexpr int kDrawsWithPrior = 24;
constexpr int kDrawsWithout = 300;
constexpr float kScoreBand = 0.08f;    // [m], near range.
constexpr float kBandGrowth = 0.015f;  // [m] per m of range.
constexpr float kBelowPenalty = 0.7f;
constexpr int kIterations = 8;
constexpr float kFirstBand = 0.30f;  // [m]
constexpr float kLastBand = 0.06f;   // [m]
constexpr float kStiffness = 1e-2f;  // Holds the tilt where the returns do not say it.
constexpr int kMinInliers = 30;
constexpr float kMaxBelowShare = 0.7f;   // Returns below the plane, over its inliers.
constexpr float kMinInlierShare = 0.2f;  // Of the weight of the returns.
constexpr float kMinSpread = 0.5f;       // [m], standard deviation of the inliers along their shorter axis.

// Lowest returns, with their weights by range. Coordinate by coordinate, so that Eigen can vectorise.
struct Candidates {
  Eigen::ArrayXf x, y, z;
  Eigen::ArrayXf weight;
  Eigen::ArrayXf inverse_band;  // Of the band's growth with range: 1 at the lidar.
  Eigen::ArrayXf scratch;

  Eigen::Index size() const { return x.size(); }
  Eigen::Vector3f At(Eigen::Index i) const { return {x[i], y[i], z[i]}; }
};

// z = a x + b y + c in the lidar frame.
using Plane = Eigen::Vector3f;

float UpOf(const Plane& plane) { return 1.0f / std::sqrt(1.0f + plane.head<2>().squaredNorm()); }

// Distances above the plane in units of `band` and its growth, into `scratch`.
void Distances(const Plane& plane, float band, Candidates* c) {
  c->scratch = (UpOf(plane) / band) * (c->z - plane.x() * c->x - plane.y() * c->y - plane.z()) * c->inverse_band;
}

float Score(const Plane& plane, Candidates* c) {
  Distances(plane, kScoreBand, c);
  const auto& d = c->scratch;
  return (c->weight * ((1.0f - d * d).max(0.0f) - kBelowPenalty * (d.min(0.0f).square() - 1.0f).max(0.0f).min(1.0f)))
      .sum();
}

bool IsPlausible(const Plane& plane) {
  const float up = UpOf(plane);
  const float height = -up * plane.z();
  return up >= kMinUp && height >= kMinHeight && height <= kMaxHeight;
}

Plane Refine(Plane plane, Candidates* c) {
  for (int i = 0; i < kIterations; ++i) {
    const float share = static_cast<float>(i) / (kIterations - 1);
    Distances(plane, kFirstBand * std::pow(kLastBand / kFirstBand, share), c);
    // Tukey's weight, half as wide above as below.
    Eigen::ArrayXf& w = c->scratch;
    w = c->weight * (1.0f - (w.max(0.0f) + 0.5f * w.min(0.0f)).square()).max(0.0f).square();
    const float xy = (w * c->x * c->y).sum();
    const float x1 = (w * c->x).sum();
    const float y1 = (w * c->y).sum();
    Eigen::Matrix3f matrix;
    matrix << (w * c->x.square()).sum() + kStiffness, xy, x1,  //
        xy, (w * c->y.square()).sum() + kStiffness, y1,        //
        x1, y1, w.sum() + 1e-6f;
    const Eigen::Vector3f right((w * c->x * c->z).sum() + kStiffness * plane.x(),
                                (w * c->y * c->z).sum() + kStiffness * plane.y(), (w * c->z).sum());
    plane = matrix.ldlt().solve(right);
  }
  return plane;
}

}  // namespace

GroundFit FitGround(const std::vector<Eigen::Vector3f>& lowest_returns, const GroundFit& prior) {
  GroundFit fit;
  const auto capacity = static_cast<Eigen::Index>(lowest_returns.size());
  Candidates candidates;
  for (Eigen::ArrayXf* array : {&candidates.x, &candidates.y, &candidates.z}) array->resize(capacity);
  Eigen::Index size = 0;
  const float max_range = prior.ok ? std::clamp(kRangePerHeight * prior.height, kMaxRange, kMaxRangeHigh) : kMaxRange;
  for (const Eigen::Vector3f& point : lowest_returns) {
    if (point.head<2>().squaredNorm() > max_range * max_range) continue;
    candidates.x[size] = point.x();
    candidates.y[size] = point.y();
    candidates.z[size] = point.z();
    ++size;
  }
  if (size < kMinInliers) return fit;
  for (Eigen::ArrayXf* array : {&candidates.x, &candidates.y, &candidates.z}) array->conservativeResize(size);
  const Eigen::ArrayXf range_squared = candidates.x.square() + candidates.y.square();
  const float near_range = kNearShare * max_range;
  candidates.weight = (1.0f + range_squared / (near_range * near_range)).square().inverse();
  candidates.inverse_band = (1.0f + kBandGrowth / kScoreBand * range_squared.sqrt()).inverse();

  Plane best = Plane::Zero();
  float best_score = 0.0f;
  if (prior.ok) {
    const Eigen::Vector3f& n = prior.normal;
    best = Plane(-n.x() / n.z(), -n.y() / n.z(), -prior.height / n.z());
    const Plane refined = Refine(best, &candidates);
    if (IsPlausible(refined)) {
      best = refined;
      best_score = Score(best, &candidates);
    }
  }
  Random random(1);
  const auto draw = [&] {
    return candidates.At(static_cast<Eigen::Index>((random.Bits() >> 32) * static_cast<uint64_t>(size) >> 32));
  };
  bool drawn_is_best = false;
  const int draws = prior.ok ? kDrawsWithPrior : kDrawsWithout;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Vector3f a = draw();
    const Eigen::Vector3f ab = draw() - a;
    const Eigen::Vector3f ac = draw() - a;
    const Eigen::Vector3f n = ab.cross(ac);
    // Three returns far enough apart to say something about the tilt.
    if (!(std::abs(n.z()) > 1.0f)) continue;
    const Plane plane(-n.x() / n.z(), -n.y() / n.z(), n.dot(a) / n.z());
    if (!IsPlausible(plane)) continue;
    const float score = Score(plane, &candidates);
    if (score > best_score) {
      best_score = score;
      best = plane;
      drawn_is_best = true;
    }
  }
  if (best_score <= 0.0f) return fit;
  if (drawn_is_best) best = Refine(best, &candidates);
  if (!IsPlausible(best)) return fit;

  fit.normal = UpOf(best) * Eigen::Vector3f(-best.x(), -best.y(), 1.0f);
  fit.height = -UpOf(best) * best.z();
  int num_below = 0;
  float sum = 0.0f;
  float square_sum = 0.0f;
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  Eigen::Matrix2f moment = Eigen::Matrix2f::Zero();
  for (Eigen::Index i = 0; i < size; ++i) {
    const Eigen::Vector3f point = candidates.At(i);
    const float distance = fit.normal.dot(point) + fit.height;
    const float relative = distance * candidates.inverse_band[i];
    if (std::abs(relative) > kScoreBand) {
      num_below += relative < 0.0f ? 1 : 0;
      continue;
    }
    const float weight = candidates.weight[i];
    ++fit.num_inliers;
    sum += weight;
    square_sum += weight * distance * distance;
    mean += weight * point.head<2>();
    moment += weight * point.head<2>() * point.head<2>().transpose();
  }
  const float all = candidates.weight.sum();
  if (fit.num_inliers < kMinInliers || sum < kMinInlierShare * all) return fit;
  if (static_cast<float>(num_below) > kMaxBelowShare * static_cast<float>(fit.num_inliers)) return fit;
  fit.rms = std::sqrt(square_sum / sum);
  mean /= sum;
  const Eigen::Matrix2f spread = moment / sum - mean * mean.transpose();
  const float half_trace = 0.5f * spread.trace();
  const float smaller = half_trace - std::sqrt(std::max(0.0f, half_trace * half_trace - spread.determinant()));
  fit.ok = smaller >= kMinSpread * kMinSpread;
  return fit;
}

}  // namespace arborslam
