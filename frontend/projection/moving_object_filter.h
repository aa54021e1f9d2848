#ifndef ARBORSLAM_FRONTEND_PROJECTION_MOVING_OBJECT_FILTER_H_
#define ARBORSLAM_FRONTEND_PROJECTION_MOVING_OBJECT_FILTER_H_

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/sensor/planar_scan.h"
#include "frontend/projection/first_returns.h"

namespace arborslam {

/// What counts as moving, section `dynamic`.
struct MovingObjectOptions {
  bool enabled = true;        ///< Whether moving things are looked for at all.
  double range = 5.0;         ///< [m], how near a thing must be to be judged: only there a sweep leaves few gaps.
  double history = 4.0;       ///< [s], how far back the sweeps lie that a sweep is compared with.
  double max_size = 2.5;      ///< [m], across: two people abreast; larger things are walls, hedges and crowns.
  double range_margin = 0.2;  ///< [m], by how much a ray must have passed a place to call it free.
  double side_margin = 0.12;  ///< [m], how far beside a ray a return still ends it: trunks' edges, errors of the pose.
  double min_free_share = 0.6;  ///< Of the votes on a thing, those that must say that its place was free.
  double body_radius = 0.25;    ///< [m], the robot's own path is free this far to either side; 0: is not used.
  /// Of the scan's points, and of the things near by: when more of them seem to move, it is the pose that is wrong.
  double max_share = 0.5;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("enabled", enabled);
    visit("range", range);
    visit("history", history);
    visit("max_size", max_size);
    visit("range_margin", range_margin);
    visit("side_margin", side_margin);
    visit("min_free_share", min_free_share);
    visit("body_radius", body_radius);
    visit("max_share", max_share);
  }
};

/// Something that moves, as one scan shows it.
struct MovingObject {
  Eigen::Vector2f center;      ///< [m, base frame], mean of its points.
  float radius;                ///< [m], of the farthest point from the centre.
  std::vector<size_t> points;  ///< Indices of the scan's points, ascending.
};

/// Finds what moves near the robot (people who follow or cross, animals) by comparing a scan with a few of those
/// before: the things (connected points) that stand where rays passed freely, or where the robot itself has been.
/// Leaves, which rays hit or pass at random, and things that a tilted sensor misses now and then are told from these by
/// the vote of all points on all earlier scans, and by what a mover leaves behind: a place where something stood is now
/// free. Deterministic; not thread-safe.
class MovingObjectFilter {
 public:
  /// `options` must be valid.
  explicit MovingObjectFilter(const MovingObjectOptions& options) : options_(options) {}

  /// What moves in `scan`, taken at `T_odom_base`, which may be a prediction: a few centimetres and hundredths of a
  /// radian do not matter. Nothing before two scans have been added. Does not add the scan.
  std::vector<MovingObject> Find(const PlanarScan& scan, const SE2& T_odom_base) const;

  /// Adds a scan, whole, at the pose that matching gave it, for the next ones to be compared with.
  void Add(const PlanarScan& scan, const SE2& T_odom_base);

  /// What it remembers of the scans.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(references_, path_);
  }

 private:
  // A scan that others are compared with.
  struct Reference {
    double stamp;
    SE2 T_odom_base;
    FirstReturns first_returns;
    std::vector<Eigen::Vector2d> near_places;  // [m, base frame], occupied, by what may have left since.

    template <class Visitor>
    void VisitState(Visitor&& visit) {
      visit(stamp, T_odom_base, first_returns, near_places);
    }
  };
  class Comparison;

  MovingObjectOptions options_;
  std::deque<Reference> references_;  // The oldest first.
  std::deque<Eigen::Vector2d> path_;  // [m, odom], places of the robot, the oldest first.
};

/// `scan` without the points of `objects`. Where rays to points are free, theirs remain so and become `free_ends`.
PlanarScan WithoutMovingObjects(const PlanarScan& scan, const std::vector<MovingObject>& objects);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_MOVING_OBJECT_FILTER_H_
