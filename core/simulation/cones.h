#ifndef ARBORSLAM_CORE_SIMULATION_CONES_H_
#define ARBORSLAM_CORE_SIMULATION_CONES_H_

#include <string>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// Traffic cones on a lawn, among which a legged robot walks a rectangle of 6 m by 2 m (16 m around), with trees, a
/// fence and a hedge in the background.
struct ConesOptions {
  ConesOptions();

  RunOptions run;
  int cones = 16;             ///< In an area of 8 m by 5 m.
  double cone_height = 0.5;   ///< [m], mean; heights lie within 0.2 m of it.
  double cone_radius = 0.16;  ///< [m], of the base, mean; radii lie within a quarter of it.
  int background_trees = 10;  ///< 10 to 20 m away.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    run.VisitFields(visit);
    visit("cones", cones);
    visit("cone_height", cone_height);
    visit("cone_radius", cone_radius);
    visit("background_trees", background_trees);
  }
};

/// `options` must be valid.
Scene MakeCones(const ConesOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_CONES_H_
