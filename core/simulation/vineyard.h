#ifndef ARBORSLAM_CORE_SIMULATION_VINEYARD_H_
#define ARBORSLAM_CORE_SIMULATION_VINEYARD_H_

#include <string>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// A vineyard: rows of posts and thin vines with a wall of leaves above, driven through by a wheeled robot with an
/// Ouster OS1-16, up one corridor and down another: about 102 m, on about 50 m by 12 m.
struct VineyardOptions {
  VineyardOptions();

  RunOptions run;
  int corridors = 5;          ///< Between the rows.
  double row_spacing = 2.5;   ///< [m].
  double row_length = 42.0;   ///< [m].
  double post_spacing = 5.0;  ///< [m].
  double vine_spacing = 1.0;  ///< [m].
  double leaf_density = 3.0;  ///< [1/m], of the leaf walls.
  double leaf_gaps = 0.04;    ///< Probability that a metre of a leaf wall is missing.
  double headland = 3.0;      ///< [m], how far beyond the rows the robot turns.
  int background_trees = 12;  ///< Around the field.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    run.VisitFields(visit);
    visit("corridors", corridors);
    visit("row_spacing", row_spacing);
    visit("row_length", row_length);
    visit("post_spacing", post_spacing);
    visit("vine_spacing", vine_spacing);
    visit("leaf_density", leaf_density);
    visit("leaf_gaps", leaf_gaps);
    visit("headland", headland);
    visit("background_trees", background_trees);
  }
};

/// `options` must be valid.
Scene MakeVineyard(const VineyardOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_VINEYARD_H_
