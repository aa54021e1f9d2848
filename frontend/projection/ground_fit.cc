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

constexpr float kMaxRange = 12.0f;  // [m], farther ground is not this plane.
constexpr float kNearRange = 4.0f;  // [m], within which the ground has about full weight.
constexpr float kMinHeight = 0.1f;  // [m], of the lidar.
constexpr float kMaxHeight = 4.0f;  // [m], of the lidar.
constexpr float kMinUp = 0.88f;     // z of the normal, about 28 deg of tilt.
constexpr int kDrawsWithPrior = 24;
constexpr int kDrawsWithout = 300;
constexpr float kScoreBand = 0.08f;    // [m], near range.
constexpr float kBandGrowth = 0.015f;  // [m] per m of range.
constexpr float kBelowPenalty = 0.7f;
constexpr int kIterations = 8;
constexpr float kFirstBand = 0.30f;  // [m]
constexpr float kLastBand = 0.06f;   // [m]
constexpr int kMinInliers = 10;
constexpr float kMinInlierShare = 0.2f;  // Of the weight of the returns.
constexpr float kMinSpread = 0.5f;       // [m], standard deviation of the inliers along their shorter axis.

// A lowest return, with its weight by range.
struct Candidate {
  Eigen::Vector3f point;
  float weight;
  float band;  // Widening by range: 1 at the lidar.
};

// z = a x + b y + c in the lidar frame.
using Plane = Eigen::Vector3f;

float Score(const std::vector<Candidate>& candidates, const Plane& plane) {
  const float up = 1.0f / std::sqrt(1.0f + plane.head<2>().squaredNorm());
  float score = 0.0f;
  for (const Candidate& c : candidates) {
    const float distance = up * (c.point.z() - plane.x() * c.point.x() - plane.y() * c.point.y() - plane.z());
    const float relative = distance / (kScoreBand * c.band);
    const float near = 1.0f - relative * relative;
    score += c.weight * (near > 0.0f ? near : (relative < 0.0f ? -kBelowPenalty * std::min(1.0f, -near) : 0.0f));
  }
  return score;
}

bool IsPlausible(const Plane& plane) {
  const float up = 1.0f / std::sqrt(1.0f + plane.head<2>().squaredNorm());
  const float height = -up * plane.z();
  return up >= kMinUp && height >= kMinHeight && height <= kMaxHeight;
}

// Weight of a return at `relative` bands above the plane: Tukey's, half as wide above as below.
float RobustWeight(float relative) {
  const float scaled = relative > 0.0f ? relative : 0.5f * relative;
  const float rest = 1.0f - scaled * scaled;
  return rest > 0.0f ? rest * rest : 0.0f;
}

Plane Refine(const std::vector<Candidate>& candidates, Plane plane) {
  for (int i = 0; i < kIterations; ++i) {
    const float share = static_cast<float>(i) / (kIterations - 1);
    const float band = kFirstBand * std::pow(kLastBand / kFirstBand, share);
    const float up = 1.0f / std::sqrt(1.0f + plane.head<2>().squaredNorm());
    Eigen::Matrix3f normal_matrix = Eigen::Vector3f(1e-2f, 1e-2f, 1e-6f).asDiagonal();
    Eigen::Vector3f right = 1e-2f * Eigen::Vector3f(plane.x(), plane.y(), 0.0f);
    for (const Candidate& c : candidates) {
      const Eigen::Vector3f row(c.point.x(), c.point.y(), 1.0f);
      const float distance = up * (c.point.z() - plane.dot(row));
      const float weight = c.weight * RobustWeight(distance / (band * c.band));
      if (weight == 0.0f) continue;
      normal_matrix += weight * row * row.transpose();
      right += weight * c.point.z() * row;
    }
    plane = normal_matrix.ldlt().solve(right);
  }
  return plane;
}

}  // namespace

GroundFit FitGround(const std::vector<Eigen::Vector3f>& lowest_returns, const GroundFit& prior) {
  GroundFit fit;
  std::vector<Candidate> candidates;
  candidates.reserve(lowest_returns.size());
  for (const Eigen::Vector3f& point : lowest_returns) {
    const float range_squared = point.head<2>().squaredNorm();
    if (range_squared > kMaxRange * kMaxRange) continue;
    const float relative = range_squared / (kNearRange * kNearRange);
    const float weight = 1.0f / ((1.0f + relative) * (1.0f + relative));
    candidates.push_back({point, weight, 1.0f + kBandGrowth / kScoreBand * std::sqrt(range_squared)});
  }
  if (candidates.size() < static_cast<size_t>(kMinInliers)) return fit;

  Plane best = Plane::Zero();
  float best_score = 0.0f;
  if (prior.ok) {
    const Eigen::Vector3f& n = prior.normal;
    best = Plane(-n.x() / n.z(), -n.y() / n.z(), -prior.height / n.z());
    const Plane refined = Refine(candidates, best);
    if (IsPlausible(refined)) {
      best = refined;
      best_score = Score(candidates, best);
    }
  }
  Random random(1);
  const auto draw = [&] { return (random.Bits() >> 32) * candidates.size() >> 32; };
  bool drawn_is_best = false;
  const int draws = prior.ok ? kDrawsWithPrior : kDrawsWithout;
  for (int i = 0; i < draws; ++i) {
    const Eigen::Vector3f a = candidates[draw()].point;
    const Eigen::Vector3f ab = candidates[draw()].point - a;
    const Eigen::Vector3f ac = candidates[draw()].point - a;
    const Eigen::Vector3f n = ab.cross(ac);
    // Three returns far enough apart to say something about the tilt.
    if (!(std::abs(n.z()) > 1.0f)) continue;
    const Plane plane(-n.x() / n.z(), -n.y() / n.z(), n.dot(a) / n.z());
    if (!IsPlausible(plane)) continue;
    const float score = Score(candidates, plane);
    if (score > best_score) {
      best_score = score;
      best = plane;
      drawn_is_best = true;
    }
  }
  if (best_score <= 0.0f) return fit;
  if (drawn_is_best) best = Refine(candidates, best);
  if (!IsPlausible(best)) return fit;

  const float up = 1.0f / std::sqrt(1.0f + best.head<2>().squaredNorm());
  fit.normal = up * Eigen::Vector3f(-best.x(), -best.y(), 1.0f);
  fit.height = -up * best.z();
  float all = 0.0f;
  float sum = 0.0f;
  float square_sum = 0.0f;
  Eigen::Vector2f mean = Eigen::Vector2f::Zero();
  Eigen::Matrix2f moment = Eigen::Matrix2f::Zero();
  for (const Candidate& c : candidates) {
    all += c.weight;
    const float distance = fit.normal.dot(c.point) + fit.height;
    if (std::abs(distance) > kScoreBand * c.band) continue;
    ++fit.num_inliers;
    sum += c.weight;
    square_sum += c.weight * distance * distance;
    mean += c.weight * c.point.head<2>();
    moment += c.weight * c.point.head<2>() * c.point.head<2>().transpose();
  }
  if (fit.num_inliers < kMinInliers || sum < kMinInlierShare * all) return fit;
  fit.rms = std::sqrt(square_sum / sum);
  mean /= sum;
  const Eigen::Matrix2f spread = moment / sum - mean * mean.transpose();
  const float half_trace = 0.5f * spread.trace();
  const float smaller = half_trace - std::sqrt(std::max(0.0f, half_trace * half_trace - spread.determinant()));
  fit.ok = smaller >= kMinSpread * kMinSpread;
  return fit;
}

}  // namespace arborslam
