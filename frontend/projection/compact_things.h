#ifndef ARBORSLAM_FRONTEND_PROJECTION_COMPACT_THINGS_H_
#define ARBORSLAM_FRONTEND_PROJECTION_COMPACT_THINGS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/sensor/planar_scan.h"

namespace arborslam {

/// How the points of trunks and posts are made to look alike from all sides, section `compact`.
struct CompactThingOptions {
  bool enabled = true;     ///< Whether this is done at all.
  double max_width = 0.7;  ///< [m], wider things are left as they are.
  double max_gap = 0.15;   ///< [m], between neighbouring points of one thing, plus what the beams' spacing gives.
  double max_share = 0.1;  ///< Of the points that a scan is matched by, those of one thing.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("enabled", enabled);
    visit("max_width", max_width);
    visit("max_gap", max_gap);
    visit("max_share", max_share);
  }
};

/// Moves the points of every compact thing (trunk, post, cone) from its visible side to the diameter across the line of
/// sight.
///
/// A trunk shows its near side only, so the mean of its returns lies some 0.8 radii before its axis and goes around the
/// axis with the sensor. Where noise blurs the arc, a match lays mean upon mean: trunks seem to follow the robot by a
/// small part of its way, and every path comes out short by about half a per cent. The diameter has its middle on the
/// axis wherever it is seen from.
///
/// A thing is a run of connected points no wider than `max_width` and no deeper than a disc of its width; its radius is
/// half its width. Meant for what projections of sweeps in space keep, which is solid; leaves, which make up much of a
/// scan in the plane, are no discs. `scan->points` must be ordered by bearing, as projections give them; their order
/// and number stay.
void CenterCompactThings(const CompactThingOptions& options, PlanarScan* scan);

/// The points [m] to match: all, but for those of things no wider than `max_width` that would be more than `max_share`
/// of them; of these some are taken evenly, but never so few that less than 50 points remain.
///
/// Beams meet near things far more often than distant ones. Two people who follow the robot can be half of a scan, and
/// their say is that it stands still. `points` must be ordered by bearing, and so is the result.
std::vector<Eigen::Vector2f> ThinnedThings(const CompactThingOptions& options,
                                           const std::vector<Eigen::Vector2f>& points);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_COMPACT_THINGS_H_
