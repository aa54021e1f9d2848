#include "frontend/projection/sweep_projector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"
#include "frontend/projection/sweep_timing.h"

namespace arborslam {
namespace {

constexpr float kCellSize = 0.5f;             // [m], of the lowest returns.
constexpr float kUsualHeight = 0.6f;          // [m], of a lidar that never saw ground.
constexpr float kUsualColumnWidth = 0.0052f;  // [rad], 0.3 deg.

// The angle between columns [rad]: the median turn between successive points that are not of one column; the usual one
// if that is nothing a lidar has.
float ColumnWidth(const std::vector<Eigen::Vector3f>& points) {
  constexpr float kLeast = static_cast<float>(DegToRad(0.05));
  constexpr float kMost = static_cast<float>(DegToRad(0.6));
  std::vector<float> turns;
  for (size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector3f& a = points[i - 1];
    const Eigen::Vector3f& b = points[i];
    const float turn = std::abs(FastAtan2(a.x() * b.y() - a.y() * b.x(), a.x() * b.x() + a.y() * b.y()));
    if (turn > kLeast) turns.push_back(turn);
  }
  if (turns.size() < 10) return kUsualColumnWidth;
  const auto middle = turns.begin() + static_cast<ptrdiff_t>(turns.size() / 2);
  std::nth_element(turns.begin(), middle, turns.end());
  return *middle <= kMost ? *middle : kUsualColumnWidth;
}

}  // namespace

SweepProjector::SweepProjector(const SweepProjectionOptions& options)
    : options_(options),
      lowest_returns_(kCellSize, static_cast<float>(options.min_range), GroundModel::kReach),
      projection_(options) {
  column_width_ = static_cast<float>(DegToRad(options.column_width));
}

PreparedSweep SweepProjector::Prepare(const LidarSweep& sweep, const SweepMotion& motion, PreparedSweep recycled) {
  PreparedSweep prepared = std::move(recycled);
  prepared.stamp = sweep.Middle();
  PointPhases(sweep, &prepared.phases);
  Deskew(sweep, prepared.phases, motion, &prepared.points);
  if (column_width_ == 0.0f && !sweep.points.empty()) column_width_ = ColumnWidth(sweep.points);
  prepared.column_width = column_width_ > 0.0f ? column_width_ : kUsualColumnWidth;

  const std::vector<Eigen::Vector3f>& lowest = lowest_returns_.Find(prepared.points, last_ground_.normal);
  prepared.fit = FitGround(lowest, last_ground_);
  if (prepared.fit.ok) last_ground_ = prepared.fit;
  prepared.ground = last_ground_;
  if (!last_ground_.ok) prepared.ground.height = kUsualHeight;
  ground_model_.Build(prepared.fit.ok ? lowest : std::vector<Eigen::Vector3f>(), prepared.ground);
  ground_model_.Measure(prepared.points, &prepared.heights);
  prepared.lidar_height = prepared.ground.height - ground_model_.HeightAt(0.0f, 0.0f);
  prepared.samples.clear();
  if (prepared.fit.ok) {
    prepared.samples = ground_model_.samples();
    canopy_height_.Add(prepared.points, prepared.heights);
  }
  const auto given = static_cast<float>(options_.mean_canopy_height);
  prepared.mean_canopy_height = given > 0.0f ? given : canopy_height_.Get();
  return prepared;
}

PlanarScan SweepProjector::Project(const PreparedSweep& prepared, const Eigen::Matrix3f& R_base_lidar) {
  PlanarScan scan = projection_.Project({&prepared.points, &prepared.heights, prepared.lidar_height,
                                         prepared.mean_canopy_height, prepared.column_width, &prepared.phases},
                                        R_base_lidar);
  scan.stamp = prepared.stamp;
  return scan;
}

}  // namespace arborslam
