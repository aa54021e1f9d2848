#ifndef ARBORSLAM_CORE_SIMULATION_FOREST_H_
#define ARBORSLAM_CORE_SIMULATION_FOREST_H_

#include <string>

#include "core/simulation/simulated_run.h"

namespace arborslam {

/// A natural forest on rough ground, through which somebody carries the lidar along a crooked figure of eight.
struct ForestOptions {
  ForestOptions();

  RunOptions run;
  double path_length = 400.0;  ///< [m], about.
  double stems = 800.0;        ///< Per hectare.
  double stem_distance = 1.5;  ///< [m], least, between trees.
  double trunk_radius = 0.13;  ///< [m], median.
  double bushes = 250.0;       ///< Per hectare.
  double leaf_density = 0.4;   ///< [1/m], of the crowns.

  /// "" or what is wrong, the key first.
  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    run.VisitFields(visit);
    visit("path_length", path_length);
    visit("stems", stems);
    visit("stem_distance", stem_distance);
    visit("trunk_radius", trunk_radius);
    visit("bushes", bushes);
    visit("leaf_density", leaf_density);
  }
};

/// `options` must be valid.
Scene MakeForest(const ForestOptions& options);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SIMULATION_FOREST_H_
