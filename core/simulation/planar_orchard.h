#ifndef ARBORSLAM_CORE_SIMULATION_PLANAR_ORCHARD_H_
#define ARBORSLAM_CORE_SIMULATION_PLANAR_ORCHARD_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/sensor/laser_scan.h"
#include "core/sensor/stamped_pose.h"
#include "core/simulation/closed_path.h"
#include "core/simulation/planar_lidar.h"
#include "core/simulation/planar_world.h"

namespace arborslam {

/// An orchard on a plane and a legged robot that walks through it. The defaults resemble the Pullally recordings.
struct PlanarOrchardOptions {
  int seed = 1;  ///< Everything random follows from it.

  int rows = 5;                     ///< Rows of trees along x.
  int trees_per_row = 13;           ///< Places for trees in each row.
  double row_spacing = 4.5;         ///< [m] between rows, along y.
  double tree_spacing = 2.0;        ///< [m] between trees of a row.
  double position_jitter = 0.15;    ///< [m], trunks stand off the grid by up to this much in x and in y.
  double trunk_radius = 0.09;       ///< [m], mean.
  double radius_spread = 0.03;      ///< [m], trunk radii differ from the mean by up to this much.
  double missing_trees = 0.08;      ///< Probability that a place is empty.
  int foliage_per_tree = 2;         ///< Discs of leaves for each tree: one around the trunk, the others along the row.
  double foliage_radius = 0.45;     ///< [m], mean; radii lie within a third of it.
  double foliage_density = 0.4;     ///< [1/m], a beam meets a leaf every 1/density metres; 0: no foliage.
  double fence_post_spacing = 3.0;  ///< [m] along three sides of the orchard; 0: no fence.
  bool hedge = true;                ///< A hedge along the fourth side (largest y).
  double headland = 2.5;            ///< [m], how far beyond the last tree of a row the robot turns.

  double step = 0.28;            ///< [m] between scans.
  double scan_period = 1.0;      ///< [s] between scans.
  int num_scans = 0;             ///< 0: once around; more than that: the robot goes around again.
  double turn_radius = 0.4;      ///< [m] of the turns at the ends of rows.
  double wander = 0.15;          ///< [m], how far the walk strays slowly to the sides.
  double step_jitter = 0.02;     ///< [m], standard deviation of the position along the path.
  double sway = 0.03;            ///< [m], standard deviation of the position across the path.
  double heading_jitter = 0.06;  ///< [rad], standard deviation of the heading off the path.
  double spoilt_scans = 0.03;    ///< Probability of a scan that the robot's tilt turns into the ground.

  PlanarLidarOptions lidar;  ///< Its keys stand in the same section.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("seed", seed);
    visit("rows", rows);
    visit("trees_per_row", trees_per_row);
    visit("row_spacing", row_spacing);
    visit("tree_spacing", tree_spacing);
    visit("position_jitter", position_jitter);
    visit("trunk_radius", trunk_radius);
    visit("radius_spread", radius_spread);
    visit("missing_trees", missing_trees);
    visit("foliage_per_tree", foliage_per_tree);
    visit("foliage_radius", foliage_radius);
    visit("foliage_density", foliage_density);
    visit("fence_post_spacing", fence_post_spacing);
    visit("hedge", hedge);
    visit("headland", headland);
    visit("step", step);
    visit("scan_period", scan_period);
    visit("num_scans", num_scans);
    visit("turn_radius", turn_radius);
    visit("wander", wander);
    visit("step_jitter", step_jitter);
    visit("sway", sway);
    visit("heading_jitter", heading_jitter);
    visit("spoilt_scans", spoilt_scans);
    lidar.VisitFields(visit);
  }
};

/// Options for an exact grid of equal trunks, seen by an exact lidar from an exact path: no foliage, no noise, no lost
/// beams, no spoilt scans, no fence and no hedge.
PlanarOrchardOptions IdealPlanarOrchardOptions();

/// A planar orchard with its exact ground truth. World frame: the path begins at the origin, about +x, between the
/// first two rows; it goes up one alley and down the next, and along the headland back to its beginning.
///
/// Every scan follows from the seed and its index alone: scans can be drawn in any order, and from several threads.
class PlanarOrchard {
 public:
  /// `options` must be valid.
  explicit PlanarOrchard(const PlanarOrchardOptions& options);

  size_t NumScans() const { return num_scans_; }

  /// Stamp of scan `index` [s], the middle of its sweep.
  double Stamp(size_t index) const { return options_.scan_period * static_cast<double>(index); }

  /// Scan `index`, in the robot's frame.
  LaserScan Scan(size_t index) const;

  /// T_world_base of scan `index`.
  SE2 TruePose(size_t index) const;

  /// True if the robot's tilt turns scan `index` into the ground.
  bool IsSpoilt(size_t index) const { return TiltOf(index).angle > 0.0; }

  /// TruePose of every scan.
  Trajectory GroundTruth() const;

  /// The trunks of the trees, without the fence posts.
  const std::vector<Disc>& trunks() const { return trunks_; }

  /// All there is to see.
  const PlanarWorld& world() const { return world_; }

  /// [m], once around.
  double PathLength() const { return path_.Length(); }

 private:
  Tilt TiltOf(size_t index) const;
  void Plant();
  void Enclose();

  PlanarOrchardOptions options_;
  PlanarLidar lidar_;
  ClosedPath path_;
  size_t num_scans_;
  double step_;  // [m], so that a whole number of steps leads around.
  std::vector<Disc> trunks_;
  PlanarWorld world_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_PLANAR_ORCHARD_H_
