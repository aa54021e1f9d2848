#include "frontend/tracking/terrain_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr int kMaxIterations = 5;
constexpr double kMinStep = 1e-5;  // [rad] and [m]
// [m], roughness of ground, and distance at which a sample's weight has fallen to a half.
constexpr double kRoughness = 0.04;
constexpr double kRobustScale = 0.08;
constexpr double kPriorTilt = DegToRad(5.0);
constexpr double kPriorHeight = 0.3;  // [m]
// More returns than this say no more about where a patch of rough ground lies.
constexpr float kFullWeight = 5.0f;

// [m], by how much the samples lie below the terrain; 0 when too few lie on it.
double MedianResidual(const std::vector<GroundSample>& samples, const TerrainMap& terrain, const SE2& T_map_base,
                      const Tilt3& tilt) {
  constexpr size_t kMinSamples = 5;
  const Eigen::Isometry3d T_base_lidar = tilt.Transform();
  std::vector<double> residuals;
  for (const GroundSample& sample : samples) {
    const Eigen::Vector3d point = T_base_lidar * sample.position.cast<double>();
    const auto surface = terrain.At(T_map_base * Eigen::Vector2d(point.head<2>()));
    if (surface) residuals.push_back(surface->z - point.z());
  }
  if (residuals.size() < kMinSamples) return 0.0;
  const auto middle = residuals.begin() + static_cast<ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return *middle;
}

}  // namespace

TerrainFit FitToTerrain(const std::vector<GroundSample>& samples, const TerrainMap& terrain, const SE2& T_map_base,
                        const Tilt3& initial) {
  TerrainFit fit;
  fit.tilt = initial;
  fit.tilt.z += MedianResidual(samples, terrain, T_map_base, initial);
  const Eigen::Rotation2Dd R_base_map(-T_map_base.theta());
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::Matrix3d rotation = fit.tilt.Rotation();
    // Unknowns: turns about base's x and y, then z.
    const Eigen::Vector3d prior_sigma(kPriorTilt, kPriorTilt, kPriorHeight);
    Eigen::Matrix3d information = prior_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    Eigen::Vector3d vector = information * Eigen::Vector3d(initial.roll - fit.tilt.roll, initial.pitch - fit.tilt.pitch,
                                                           initial.z - fit.tilt.z);
    double sum = 0.0;
    double sum_weight = 0.0;
    fit.num_matched = 0;
    for (const GroundSample& sample : samples) {
      const Eigen::Vector3d point = rotation * sample.position.cast<double>();
      const auto surface = terrain.At(T_map_base * Eigen::Vector2d(point.head<2>()));
      if (!surface) continue;
      const Eigen::Vector2d slope = R_base_map * surface->slope;
      const double residual = fit.tilt.z + point.z() - surface->z;
      // Turning the point by (a, b) about x and y moves it by (b z, -a z, a y - b x).
      const Eigen::Vector3d jacobian(point.y() + slope.y() * point.z(), -point.x() - slope.x() * point.z(), 1.0);
      const double ratio = residual / kRobustScale;
      const double weight =
          std::min(sample.weight, kFullWeight) / kFullWeight / (kRoughness * kRoughness * (1.0 + ratio * ratio));
      information += weight * jacobian * jacobian.transpose();
      vector -= weight * residual * jacobian;
      sum += weight * residual * residual;
      sum_weight += weight;
      ++fit.num_matched;
    }
    fit.rms = sum_weight > 0.0 ? std::sqrt(sum / sum_weight) : 0.0;
    const Eigen::Vector3d step = information.ldlt().solve(vector);
    fit.tilt.roll += step.x();
    fit.tilt.pitch += step.y();
    fit.tilt.z += step.z();
    if (step.cwiseAbs().maxCoeff() < kMinStep) break;
  }
  return fit;
}

}  // namespace arborslam
