#include "backend/terrain/scan_tilts.h"

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <optional>

#include "backend/terrain/level_estimate.h"
#include "core/map/terrain_map.h"
#include "frontend/tracking/terrain_fit.h"

namespace arborslam {
namespace {

// Of the plane between the grounds of two runs: solutions, the distance at which a place's weight has fallen to a half
// [m], and the weight of a level plane, as of one place a metre from the middle of all.
constexpr int kPlaneIterations = 5;
constexpr double kPlaneScale = 0.15;
constexpr double kLevelWeight = 1.0;

SE2 PoseOf(const PosedScan& scan, const PoseGraph& graph) { return graph.Pose(scan.keyframe) * scan.T_keyframe_scan; }

using Scans = std::vector<PosedScan>::const_iterator;

TerrainMap GroundOf(const TerrainOptions& options, const PoseGraph& graph, Scans begin, Scans end) {
  TerrainMap ground(options.cell_size);
  for (Scans scan = begin; scan != end; ++scan) {
    const Eigen::Isometry3d T_map_lidar = Lift(PoseOf(*scan, graph), scan->tilt);
    const std::shared_ptr<const std::vector<GroundSample>> samples = scan->ground.Get();
    for (const GroundSample& sample : *samples) {
      ground.Insert(T_map_lidar * sample.position.cast<double>(), sample.weight);
    }
  }
  return ground;
}

// How much higher one ground is than another, at some place.
struct Step {
  Eigen::Vector2d place;
  double height;
};

// The plane (height at the origin, slopes) through the steps, by robust least squares (Cauchy).
Eigen::Vector3d PlaneThrough(const std::vector<Step>& steps) {
  // About the middle, so that a slope that the places do not tell stays 0 there.
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Step& step : steps) middle += step.place / static_cast<double>(steps.size());
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (int iteration = 0; iteration < kPlaneIterations; ++iteration) {
    Eigen::Matrix3d information = Eigen::Vector3d(0.0, kLevelWeight, kLevelWeight).asDiagonal();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    for (const Step& step : steps) {
      const double ratio = (step.height - plane.x() - plane.tail<2>().dot(step.place)) / kPlaneScale;
      const double weight = iteration == 0 ? 1.0 : 1.0 / (1.0 + ratio * ratio);
      const Eigen::Vector3d basis(1.0, step.place.x() - middle.x(), step.place.y() - middle.y());
      information += weight * basis * basis.transpose();
      vector += weight * step.height * basis;
    }
    plane = information.ldlt().solve(vector);
    plane.x() -= plane.tail<2>().dot(middle);
  }
  return plane;
}

}  // namespace

void SmoothTilts(const TerrainOptions& options, const PoseGraph& graph, std::vector<PosedScan>* scans) {
  const bool is_spatial =
      std::any_of(scans->begin(), scans->end(), [](const PosedScan& scan) { return !scan.ground.Get()->empty(); });
  if (!is_spatial) return;
  // Evenly along the path, so that no place counts more because the robot stood there.
  std::vector<TerrainView> views;
  for (const PosedScan& scan : *scans) {
    const SE2 pose = PoseOf(scan, graph);
    const bool is_far = views.empty() ||
                        (views.back().T_map_base.translation() - pose.translation()).norm() >= options.keyframe_spacing;
    if (is_far && !scan.ground.Get()->empty()) views.push_back({pose, scan.ground, scan.local_tilt, scan.tilt});
  }
  const SmoothedTerrain smoothed = SmoothTerrain(options, &views);
  for (PosedScan& scan : *scans) {
    const std::shared_ptr<const std::vector<GroundSample>> ground = scan.ground.Get();
    if (ground->empty()) continue;
    const std::vector<GroundSample> samples = WithoutBias(smoothed.bias, scan.tilt, *ground);
    scan.tilt = FitToTerrain(samples, smoothed.terrain, PoseOf(scan, graph), scan.tilt).tilt;
  }
  std::vector<UprightView> upright;
  for (const PosedScan& scan : *scans) {
    if (scan.lines.Get()->empty()) continue;
    upright.push_back({PoseOf(scan, graph), scan.tilt, scan.odometry_tilt, scan.lines});
  }
  const LevelEstimate level = EstimateLevel(upright);
  for (PosedScan& scan : *scans) scan.tilt = MadeUpright(scan.tilt, PoseOf(scan, graph), level);
}

void LayOnKnownGround(const TerrainOptions& options, const PoseGraph& graph, size_t num_known,
                      std::vector<PosedScan>* scans) {
  const auto middle = scans->begin() + static_cast<std::ptrdiff_t>(num_known);
  const TerrainMap known = GroundOf(options, graph, scans->begin(), middle);
  const TerrainMap fresh = GroundOf(options, graph, middle, scans->end());
  std::vector<Step> steps;
  for (auto scan = middle; scan != scans->end(); ++scan) {
    const Eigen::Vector2d place = PoseOf(*scan, graph).translation();
    const std::optional<TerrainMap::Surface> below = known.At(place);
    const std::optional<TerrainMap::Surface> above = fresh.At(place);
    if (below && above) steps.push_back({place, below->z - above->z});
  }
  if (steps.empty()) return;
  const Eigen::Vector3d plane = PlaneThrough(steps);
  // What `MadeUpright` takes to be upright is what heights are measured along.
  LevelEstimate turn;
  turn.lean = plane.tail<2>();
  for (auto scan = middle; scan != scans->end(); ++scan) {
    scan->tilt = MadeUpright(scan->tilt, PoseOf(*scan, graph), turn);
    scan->tilt.z += plane.x();
  }
}

}  // namespace arborslam
