#ifndef ARBORSLAM_FRONTEND_PROJECTION_LASER_PROJECTION_H_
#define ARBORSLAM_FRONTEND_PROJECTION_LASER_PROJECTION_H_

#include <string>

#include "core/sensor/laser_scan.h"
#include "core/sensor/planar_scan.h"

namespace arborslam {

/// Which returns of a planar lidar are used.
struct ProjectionOptions {
  double min_range = 0.5;  ///< [m], nearer returns are the robot itself.
  double max_range =
      15.0;  ///< [m], farther returns are left out: tilt makes them unsure. Their rays still count as free.
  double max_bearing = 3.0;  ///< [rad], returns from farther behind than this are left out: the operator walks there.
  double point_spacing = 0.03;  ///< [m], returns closer together than this are merged into one point; 0 keeps all.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("min_range", min_range);
    visit("max_range", max_range);
    visit("max_bearing", max_bearing);
    visit("point_spacing", point_spacing);
  }
};

/// The planar points of a scan in the `base` frame (here the lidar's own), in the order of their beams. Beams without a
/// return say nothing; beams whose return lies beyond `max_range` are known to be free up to there.
PlanarScan ProjectLaserScan(const LaserScan& scan, const ProjectionOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_LASER_PROJECTION_H_
