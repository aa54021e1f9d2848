#ifndef ARBORSLAM_CORE_SIMULATION_CITRUS_H_
#define ARBORSLAM_CORE_SIMULATION_CITRUS_H_

#include <string>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// A grove of citrus trees with crowns almost down to the ground, driven through by a wheeled robot: about 865 m along
/// every lane and some of them twice, on about 60 m by 48 m.
struct CitrusOptions {
  CitrusOptions();

  RunOptions run;
  int rows = 7;                 ///< Rows of trees along x; the robot also drives along the outer sides.
  double row_spacing = 6.86;    ///< [m].
  double row_length = 58.8;     ///< [m].
  double tree_spacing = 3.0;    ///< [m] between trees of a row.
  double missing_trees = 0.06;  ///< Probability that a place is empty.
  double leaf_density = 1.2;    ///< [1/m], of the crowns.
  double headland = 3.5;        ///< [m], how far beyond the rows the robot turns.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    run.VisitFields(visit);
    visit("rows", rows);
    visit("row_spacing", row_spacing);
    visit("row_length", row_length);
    visit("tree_spacing", tree_spacing);
    visit("missing_trees", missing_trees);
    visit("leaf_density", leaf_density);
    visit("headland", headland);
  }
};

/// `options` must be valid.
Scene MakeCitrus(const CitrusOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_CITRUS_H_
