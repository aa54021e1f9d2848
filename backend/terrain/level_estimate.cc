#include "backend/terrain/level_estimate.h"

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

namespace arborslam {
namespace {

constexpr int kIterations = 15;
constexpr double kLean = 0.06;         // [rad], standard deviation of a trunk's own lean.
constexpr double kRangeNoise = 0.025;  // [m], of a return.
constexpr double kRobustScale = 0.1;   // [rad], slope at which a line's weight has fallen to a half.
// [rad], by how much a map lean that was made level by the ground alone.
constexpr double kGroundSigma = 0.03;
constexpr double kTaperSigma = 0.05;
// [rad], by how much all upright things of a site may lean together (wind, slope, leaf walls).
constexpr double kCommonLean = 0.008;

}  // namespace

LevelEstimate EstimateLevel(const std::vector<UprightView>& views) {
  struct Line {
    Eigen::Vector2d direction;  // In the map's axes.
    double slope;
    double weight;
  };
  std::vector<Line> lines;
  std::set<std::pair<int64_t, int64_t>> places;
  for (const UprightView& view : views) {
    // Turning a point by (a, b) about base's x and y moves it by (b, -a) for every metre up.
    const Eigen::Vector2d change(view.tilt.pitch - view.tilt_when_seen.pitch,
                                 view.tilt_when_seen.roll - view.tilt.roll);
    const Eigen::Matrix2d rotation = view.T_map_base.rotation();
    const std::shared_ptr<const std::vector<UprightLine>> seen = view.lines.Get();
    for (const UprightLine& line : *seen) {
      const Eigen::Vector2d direction = line.direction.cast<double>();
      const double variance = kLean * kLean + kRangeNoise * kRangeNoise / static_cast<double>(line.spread);
      lines.push_back({rotation * direction, static_cast<double>(line.slope) + direction.dot(change), 1.0 / variance});
      const Eigen::Vector2d place = view.T_map_base * Eigen::Vector2d(static_cast<double>(line.range) * direction);
      places.insert({std::llround(place.x()), std::llround(place.y())});
    }
  }
  LevelEstimate estimate;
  estimate.num_places = places.size();
  estimate.sigma = kGroundSigma;
  if (places.empty()) return estimate;
  Eigen::Vector3d solution = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    information = Eigen::Vector3d(0.0, 0.0, 1.0 / (kTaperSigma * kTaperSigma)).asDiagonal();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    for (const Line& line : lines) {
      const Eigen::Vector3d jacobian(line.direction.x(), line.direction.y(), 1.0);
      const double ratio = (line.slope - jacobian.dot(solution)) / kRobustScale;
      const double weight = line.weight / (1.0 + ratio * ratio);
      information += weight * jacobian * jacobian.transpose();
      vector += weight * line.slope * jacobian;
    }
    information.diagonal().array() += 1e-6;
    solution = information.ldlt().solve(vector);
  }
  // Lines of one trunk lean together, and not every place is a trunk of its own; each tells one direction of two.
  const double num_trunks = 0.25 * static_cast<double>(places.size());
  const double common = kCommonLean * kCommonLean + kLean * kLean / (0.5 * num_trunks);
  const Eigen::Matrix2d covariance =
      Eigen::Matrix2d(information.inverse().topLeftCorner<2, 2>()) + common * Eigen::Matrix2d::Identity();
  estimate.sigma = std::sqrt(0.5 * covariance.trace());
  const Eigen::Matrix2d prior = kGroundSigma * kGroundSigma * Eigen::Matrix2d::Identity();
  estimate.lean = prior * (prior + covariance).inverse() * solution.head<2>();
  return estimate;
}

Tilt3 MadeUpright(const Tilt3& tilt, const SE2& T_map_base, const LevelEstimate& level) {
  const Eigen::Vector3d up = Eigen::Vector3d(level.lean.x(), level.lean.y(), 1.0).normalized();
  const Eigen::Matrix3d upright = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Isometry3d T_map_lidar = Lift(T_map_base, tilt);
  Tilt3 result = TiltOf(upright * T_map_lidar.linear());
  result.z = (upright * T_map_lidar.translation()).z();
  return result;
}

}  // namespace arborslam
