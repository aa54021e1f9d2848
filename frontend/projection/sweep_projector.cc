#include "frontend/projection/sweep_projector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"
#include "frontend/projection/ground_search.h"
#include "frontend/projection/sweep_timing.h"

namespace arborslam {
namespace {

constexpr float kCellSize = 0.5f;             // [m], of the lowest returns.
constexpr float kUsualHeight = 0.6f;          // [m], of a lidar that never saw ground.
constexpr float kUsualColumnWidth = 0.0052f;  // [rad], 0.3 deg.
constexpr float kMaxFitRange = 18.0f;         // [m], within which returns are counted.
constexpr float kClearlyMore = 1.2f;          // Returns on the ground, times those of another fit.
constexpr float kDeep = 0.3f;                 // [m], plus kDeepGrowth of the range: as much below the ground as neither
constexpr float kDeepGrowth = 0.08f;          // terrain nor a step of the robot accounts for.
constexpr float kMaxDeepShare = 0.02f;        // Of the lowest returns.
constexpr float kFloor = 0.12f;               // [m], plus kFloorGrowth of the range: returns below are ghosts.
constexpr float kFloorGrowth = 0.03f;
constexpr float kGroundBand = 0.08f;  // [m], plus kGroundGrowth of the range.
constexpr float kGroundGrowth = 0.015f;
constexpr float kMaxTilt = 0.49f;   // [rad], of the ground seen from the lidar,
constexpr float kMinHeight = 0.1f;  // [m], of the lidar above it,
constexpr float kMaxHeight = 5.5f;  // [m], as FitGround has them.

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

GroundPlane SearchUsualGround(const std::vector<Eigen::Vector3f>& points) {
  GroundSearchRegion region;
  region.max_tilt = kMaxTilt;
  region.min_height = kMinHeight;
  region.max_height = kMaxHeight;
  return SearchGround(points, region);
}

GroundFit ToFit(const GroundPlane& plane) {
  GroundFit fit;
  fit.normal = plane.normal;
  fit.height = plane.height;
  fit.ok = plane.ok;
  return fit;
}

// Of `points` within reach of the fit, the number of those that are `from` to `to` above `ground`, in units of
// `band + growth * range`, and the number of all.
struct Counts {
  size_t within = 0;
  size_t all = 0;
};
Counts CountWithin(const std::vector<Eigen::Vector3f>& points, const GroundFit& ground, float band, float growth,
                   float from, float to) {
  Counts counts;
  for (const Eigen::Vector3f& point : points) {
    const float range_squared = point.head<2>().squaredNorm();
    if (range_squared > kMaxFitRange * kMaxFitRange) continue;
    const float relative = (ground.normal.dot(point) + ground.height) / (band + growth * std::sqrt(range_squared));
    ++counts.all;
    counts.within += relative >= from && relative <= to ? 1 : 0;
  }
  return counts;
}

// True where more of the lowest returns are far below `ground` than on any terrain.
bool HasGhosts(const std::vector<Eigen::Vector3f>& lowest, const GroundFit& ground) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Counts deep = CountWithin(lowest, ground, kDeep, kDeepGrowth, -kInfinity, -1.0f);
  return static_cast<float>(deep.within) > kMaxDeepShare * static_cast<float>(deep.all);
}

float NumOnGround(const std::vector<Eigen::Vector3f>& points, const GroundFit& ground) {
  return static_cast<float>(CountWithin(points, ground, kGroundBand, kGroundGrowth, -1.0f, 1.0f).within);
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
  if (column_width_ == 0.0f && !sweep.points.empty()) column_width_ = ColumnWidth(PointsAboutSpinAxis(sweep));
  prepared.column_width = column_width_ > 0.0f ? column_width_ : kUsualColumnWidth;

  const std::vector<Eigen::Vector3f>& lowest = lowest_returns_.Find(prepared.points, last_ground_.normal);
  prepared.fit = FitGround(lowest, last_ground_);
  CheckFit(&prepared);
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

void SweepProjector::CheckFit(PreparedSweep* prepared) {
  const std::vector<Eigen::Vector3f>& points = prepared->points;
  GroundFit expected = last_ground_;
  if (!last_ground_.ok || !prepared->fit.ok) {
    const GroundFit searched = ToFit(SearchUsualGround(points));
    if (!searched.ok) return;
    if (!last_ground_.ok) expected = searched;
    GroundFit fit = FitGround(lowest_returns_.returns(), searched);
    if (!fit.ok) fit = searched;
    if (!prepared->fit.ok || NumOnGround(points, fit) > kClearlyMore * NumOnGround(points, prepared->fit)) {
      prepared->fit = fit;
    }
  }
  if (HasGhosts(lowest_returns_.returns(), expected)) FitAmongGhosts(expected, prepared);
}

void SweepProjector::FitAmongGhosts(const GroundFit& expected, PreparedSweep* prepared) {
  const std::vector<Eigen::Vector3f>& points = prepared->points;
  GroundFit ground = last_ground_.ok ? ToFit(SearchUsualGround(points)) : expected;
  if (!ground.ok) ground = expected;
  std::vector<Eigen::Vector3f> real;
  real.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    const float floor = -kFloor - kFloorGrowth * point.head<2>().norm();
    if (ground.normal.dot(point) + ground.height >= floor) real.push_back(point);
  }
  prepared->fit = FitGround(lowest_returns_.Find(real, ground.normal), ground);
  if (!prepared->fit.ok || NumOnGround(points, ground) > kClearlyMore * NumOnGround(points, prepared->fit)) {
    prepared->fit = ground;
  }
}

PlanarScan SweepProjector::Project(const PreparedSweep& prepared, const Eigen::Matrix3f& R_base_lidar) {
  PlanarScan scan = projection_.Project({&prepared.points, &prepared.heights, prepared.lidar_height,
                                         prepared.mean_canopy_height, prepared.column_width, &prepared.phases},
                                        R_base_lidar);
  scan.stamp = prepared.stamp;
  return scan;
}

}  // namespace arborslam
