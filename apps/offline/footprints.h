#ifndef ARBORSLAM_APPS_OFFLINE_FOOTPRINTS_H_
#define ARBORSLAM_APPS_OFFLINE_FOOTPRINTS_H_

#include "apps/offline/second_pass.h"
#include "backend/slam_options.h"
#include "core/io/map_io.h"
#include "core/map/fine_map.h"
#include "frontend/projection/sweep_projector.h"

namespace arborslam {

/// The map in cells smaller than those of the estimation, from sweeps at their final poses: `FineMap` fed with what
/// stands up to 1 m above the ground, and with the ground.
class Footprints {
 public:
  /// @param evidence the map in the estimation's cells.
  /// @param options  valid ones, with a resolution above 0. Throws as `FineMap` does.
  Footprints(const GridImage& evidence, const FineMapOptions& options, const SlamOptions& slam_options);

  /// Takes a matched sweep; spoilt ones are left aside.
  void Add(const PosedSweep& sweep);

  GridImage Image() const { return map_.Image(); }

 private:
  SlamOptions options_;
  FineMap map_;
  SweepProjector projector_;
  PreparedSweep prepared_;  // Of the last sweep; its memory is used again.
};

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_FOOTPRINTS_H_
