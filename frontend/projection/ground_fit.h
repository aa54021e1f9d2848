#ifndef ARBORSLAM_FRONTEND_PROJECTION_GROUND_FIT_H_
#define ARBORSLAM_FRONTEND_PROJECTION_GROUND_FIT_H_

#include <Eigen/Core>
#include <vector>

namespace arborslam {

/// The ground around the lidar as a plane.
struct GroundFit {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  ///< Unit vector, up, in the lidar frame.
  float height = 0.0f;                                ///< [m], of the lidar above the plane.
  int num_inliers = 0;                                ///< Of the lowest returns.
  float rms = 0.0f;                                   ///< [m], of the inliers' weighted distances.
  bool ok = false;                                    ///< False when no ground is in sight; the rest is then void.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(normal, height, num_inliers, rms, ok);
  }
};

/// Fits a plane to the lowest returns of a sweep (`LowestReturns`).
///
/// Candidates are planes through three returns, drawn the same on every run and machine, and `prior`, the fit of the
/// sweep before. The best by a score that rewards returns near the plane and punishes those below it is refined by
/// iteratively reweighted least squares, the band of what counts narrowing; returns above the plane (grass, stems,
/// leaves) lose weight sooner than those below, and near ground weighs more than far ground, where the terrain is
/// another. A prior that has become wrong is outvoted by a drawn plane: it only saves most of the draws.
///
/// `prior.ok` false: the height is unknown and many planes are drawn. Returns count within 12 m, up to 18 m when
/// the prior has the lidar higher than 2.4 m, whose lowest beams meet the ground far off. The fit is not `ok` when the
/// plane has too few inliers, when these are a small part of the lowest returns near the lidar or lie along a line, or
/// when much lies below it.
GroundFit FitGround(const std::vector<Eigen::Vector3f>& lowest_returns, const GroundFit& prior);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_GROUND_FIT_H_
