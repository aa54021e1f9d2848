#include "frontend/projection/sweep_timing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/cpu_clones.h"
#include "frontend/projection/fast_atan2.h"

namespace arborslam {
namespace {

constexpr size_t kMinPoints = 64;
constexpr size_t kColumnBlocks = 64;     // Pieces of the file in which a sweep by columns turns steadily.
constexpr size_t kMostSamples = 48;      // Of a piece.
constexpr size_t kRingBlockPoints = 8;   // Neighbours in a ring.
constexpr float kMinSteadiness = 0.8f;   // Net turning over all turning.
constexpr float kMaxColumnTurns = 1.5f;  // More turns than this are rings.
constexpr float kMinSameSign = 0.8f;     // Share of steps that turn the rings' way.
constexpr float kInverseTurn = 0.159154943f;
constexpr size_t kLanes = 8;
constexpr size_t kSeamBins = 90;

// To [-0.5, 0.5], from [-1, 1].
float WrapTurn(float turns) { return turns > 0.5f ? turns - 1.0f : (turns < -0.5f ? turns + 1.0f : turns); }

// Azimuths [turns] of the mean horizontal positions of pieces of `size` points, in the order of the file. Of long
// pieces only some points are looked at.
std::vector<float> BlockAzimuths(const std::vector<Eigen::Vector3f>& points, size_t size) {
  std::vector<float> azimuths;
  azimuths.reserve(points.size() / size + 1);
  const size_t stride = std::max<size_t>(1, size / kMostSamples);
  for (size_t begin = 0; begin + size <= points.size(); begin += size) {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    for (size_t i = begin; i < begin + size; i += stride) {
      const Eigen::Vector2f flat = points[i].head<2>();
      sum += flat / std::sqrt(flat.squaredNorm() + 1e-12f);
    }
    azimuths.push_back(kInverseTurn * FastAtan2(sum.y(), sum.x()));
  }
  return azimuths;
}

// The azimuth [turns] at which most rings begin: where the elevation jumps from one point to the next.
float RingSeam(const std::vector<Eigen::Vector3f>& points) {
  std::array<float, kSeamBins> jumps{};
  float last = 0.0f;
  for (size_t i = 0; i < points.size(); ++i) {
    const float slope = points[i].z() / std::sqrt(points[i].head<2>().squaredNorm() + 1e-12f);
    const float jump = i > 0 ? std::abs(slope - last) : 0.0f;
    last = slope;
    if (jump < 0.002f) continue;
    const float azimuth = kInverseTurn * FastAtan2(points[i].y(), points[i].x());
    const auto bin = static_cast<size_t>((azimuth - std::floor(azimuth)) * kSeamBins) % kSeamBins;
    jumps[bin] += std::min(jump, 0.02f);
  }
  const auto most = static_cast<size_t>(std::max_element(jumps.begin(), jumps.end()) - jumps.begin());
  return (static_cast<float>(most) + 0.5f) / kSeamBins;
}

}  // namespace

ARBORSLAM_CPU_CLONES void PointPhases(const LidarSweep& sweep, std::vector<float>* phases) {
  phases->clear();
  const std::vector<Eigen::Vector3f>& points = sweep.points;
  if (!(sweep.duration > 0.0)) return;
  if (sweep.times.size() == points.size()) {
    const auto scale = static_cast<float>(1.0 / sweep.duration);
    phases->resize(points.size());
    for (size_t i = 0; i < points.size(); ++i) (*phases)[i] = std::clamp(scale * sweep.times[i], 0.0f, 1.0f);
    return;
  }
  if (points.size() < kMinPoints) return;
  if (sweep.spin_axis != Eigen::Vector3f::UnitZ()) {
    LidarSweep upright = sweep;
    upright.points = PointsAboutSpinAxis(sweep);
    upright.spin_axis = Eigen::Vector3f::UnitZ();
    PointPhases(upright, phases);
    return;
  }

  const size_t block = (points.size() + kColumnBlocks - 1) / kColumnBlocks;
  const std::vector<float> columns = BlockAzimuths(points, block);
  float net = 0.0f;
  float all = 0.0f;
  for (size_t b = 1; b < columns.size(); ++b) {
    const float step = WrapTurn(columns[b] - columns[b - 1]);
    net += step;
    all += std::abs(step);
  }
  if (std::abs(net) > kMinSteadiness * all && std::abs(net) < kMaxColumnTurns) {
    const float sense = net > 0.0f ? 1.0f : -1.0f;
    phases->resize(points.size());
    Azimuths(points.data(), points.size(), phases->data());
    float turned = 0.0f;  // Of the block's mean, since the first block's.
    // Least and most by lanes, which the compiler can vectorise.
    std::array<float, kLanes> least{};
    std::array<float, kLanes> most{};
    for (size_t b = 0; b * block < points.size(); ++b) {
      if (b > 0 && b < columns.size()) turned += sense * WrapTurn(columns[b] - columns[b - 1]);
      // What is left over after the last whole block goes by that block.
      const float mean = columns[std::min(b, columns.size() - 1)];
      const size_t end = std::min(points.size(), (b + 1) * block);
      float* const phase = phases->data();
      for (size_t i = b * block; i < end; ++i) phase[i] = turned + sense * WrapTurn(kInverseTurn * phase[i] - mean);
      for (size_t i = b * block; i < end; i += kLanes) {
        const size_t num_lanes = std::min(kLanes, end - i);
        for (size_t lane = 0; lane < num_lanes; ++lane) {
          least[lane] = phase[i + lane] < least[lane] ? phase[i + lane] : least[lane];
          most[lane] = phase[i + lane] > most[lane] ? phase[i + lane] : most[lane];
        }
      }
    }
    const float first = *std::min_element(least.begin(), least.end());
    const float last = *std::max_element(most.begin(), most.end());
    const float scale = 1.0f / std::max(1.0f, last - first);
    for (float& phase : *phases) phase = scale * (phase - first);
    return;
  }

  const std::vector<float> pieces = BlockAzimuths(points, kRingBlockPoints);
  size_t forward = 0;
  size_t backward = 0;
  for (size_t b = 1; b < pieces.size(); ++b) {
    const float step = WrapTurn(pieces[b] - pieces[b - 1]);
    forward += step > 0.0f ? 1 : 0;
    backward += step < 0.0f ? 1 : 0;
  }
  if (static_cast<float>(std::max(forward, backward)) < kMinSameSign * static_cast<float>(pieces.size() - 1)) return;
  const float sense = forward > backward ? 1.0f : -1.0f;
  const float seam = RingSeam(points);
  phases->resize(points.size());
  Azimuths(points.data(), points.size(), phases->data());
  for (float& phase : *phases) {
    const float turned = sense * (kInverseTurn * phase - seam);
    phase = turned - std::floor(turned);
  }
}

std::vector<Eigen::Vector3f> PointsAboutSpinAxis(const LidarSweep& sweep) {
  std::vector<Eigen::Vector3f> points = sweep.points;
  if (sweep.spin_axis == Eigen::Vector3f::UnitZ()) return points;
  const Eigen::Matrix3f rotation =
      Eigen::Quaternionf::FromTwoVectors(sweep.spin_axis, Eigen::Vector3f::UnitZ()).toRotationMatrix();
  for (Eigen::Vector3f& point : points) point = rotation * point;
  return points;
}

std::vector<float> PointPhases(const LidarSweep& sweep) {
  std::vector<float> phases;
  PointPhases(sweep, &phases);
  return phases;
}

}  // namespace arborslam
