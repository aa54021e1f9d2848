#ifndef ARBORSLAM_CORE_SIMULATION_ORCHARD_H_
#define ARBORSLAM_CORE_SIMULATION_ORCHARD_H_

#include <string>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// A small orchard whose rows hold different kinds of trees, walked through by a trotting robot that people follow:
/// about 150 m up and down four lanes, with a VLP-16 that spins at 20 Hz and of which every fifth sweep is recorded.
struct OrchardOptions {
  OrchardOptions();

  RunOptions run;
  int rows = 7;                 ///< Rows of trees along x.
  double row_spacing = 4.5;     ///< [m].
  double row_length = 27.0;     ///< [m].
  double tree_spacing = 2.4;    ///< [m] between trees of a row, mean of the kinds.
  double missing_trees = 0.08;  ///< Probability that a place is empty.
  double leaf_density = 0.7;    ///< [1/m], of the crowns.
  double headland = 2.2;        ///< [m], how far beyond the rows the robot turns.
  bool hedge = true;            ///< A hedge along the side of largest y, a fence along the others.

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
    visit("hedge", hedge);
  }
};

/// `options` must be valid.
Scene MakeOrchard(const OrchardOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_ORCHARD_H_
