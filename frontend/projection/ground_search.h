#ifndef ARBORSLAM_FRONTEND_PROJECTION_GROUND_SEARCH_H_
#define ARBORSLAM_FRONTEND_PROJECTION_GROUND_SEARCH_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// Where `SearchGround` searches.
struct GroundSearchRegion {
  Eigen::Vector3f up = Eigen::Vector3f::UnitZ();  ///< Unit vector in the frame of the points.
  float min_tilt = 0.0f;                          ///< [rad], between `up` and the plane's normal.
  float max_tilt = 3.15f;                         ///< [rad], likewise; pi or more: any.
  float min_height = 0.1f;                        ///< [m], of the frame's origin above the plane.
  float max_height = 6.0f;                        ///< [m]
};

/// The ground as `SearchGround` finds it. Shares are of the returns that it looks at, thinned and weighted by range.
struct GroundPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  ///< Unit vector, up, in the frame of the points.
  float height = 0.0f;                                ///< [m], of the frame's origin above the plane.
  float share = 0.0f;                                 ///< Of the returns on the plane, in [0, 1].
  float share_below = 0.0f;                           ///< Of the returns below it.
  float score = 0.0f;                                 ///< What planes are compared by; 0: none was found.
  bool ok = false;                                    ///< False where it may be anything but ground.
};

/// Searches all planes of `region` for the ground: the plane that many returns lie on and few lie below, by random
/// sampling (Fischler and Bolles 1981), the same on every run and machine, and iteratively reweighted total least
/// squares. Unlike `FitGround` it needs no idea of what is up, and since it goes by all returns instead of the lowest,
/// it stands a tenth of returns below the ground (mirrored by puddles, or of multipath). It is slower and less exact.
/// The plane is not `ok` when few returns lie on it, when these lie along a line, when much lies below it, or when it
/// is that of a lidar with one ring.
/// @param points [m], finite; those nearer than 0.5 m are the robot itself.
GroundPlane SearchGround(const std::vector<Eigen::Vector3f>& points, const GroundSearchRegion& region);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_GROUND_SEARCH_H_
