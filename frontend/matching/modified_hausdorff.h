#ifndef ARBORSLAM_FRONTEND_MATCHING_MODIFIED_HAUSDORFF_H_
#define ARBORSLAM_FRONTEND_MATCHING_MODIFIED_HAUSDORFF_H_

#include <string>
#include <vector>

namespace arborslam {

/// How many of a scan's points take part in the modified Hausdorff distance (MHD).
struct MhdOptions {
  double alpha_min = 0.7;  ///< Least inlier ratio alpha = K / number of points (paper, below eq. 12).
  double alpha_max = 0.8;  ///< Greatest inlier ratio.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("alpha_min", alpha_min);
    visit("alpha_max", alpha_max);
  }
};

/// The K of paper eq. 9-12: all points nearer than D_max, but no fewer than alpha_min and no more than alpha_max of
/// `num_points`. 0 only when `num_points` is 0.
int ChooseK(int num_near, int num_points, const MhdOptions& options);

/// An MHD with what it was made of.
struct MhdResult {
  double score = 0.0;         ///< [m], mean of the K smallest distances; D_max without any point.
  int num_used = 0;           ///< K.
  double inlier_ratio = 0.0;  ///< Share of all points that are nearer than D_max.
  double cutoff = 0.0;        ///< [m], the largest distance used.
};

/// The modified Hausdorff distance (paper eq. 9-12) of the points whose distances to the map are `distances` [m];
/// distances of `max_distance` (D_max) or more count as `max_distance`, so that a scan that mostly meets nothing scores
/// badly. `distances` is reordered.
MhdResult ModifiedHausdorff(std::vector<float>* distances, double max_distance, const MhdOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_MATCHING_MODIFIED_HAUSDORFF_H_
