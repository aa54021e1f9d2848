#ifndef ARBORSLAM_CORE_MAP_CLOUD_OPTIONS_H_
#define ARBORSLAM_CORE_MAP_CLOUD_OPTIONS_H_

#include <string>

namespace arborslam {

/// What goes into the 3D map and how fine it is.
struct CloudOptions {
  bool enabled = true;       ///< Whether a 3D map is made at all.
  double voxel_size = 0.1;   ///< [m], edge of the cubes that returns are merged in.
  int min_sweeps = 3;        ///< A voxel that fewer sweeps met is left out: people who passed, leaves in the wind.
  double min_range = 0.5;    ///< [m], nearer returns are the robot itself.
  double max_range = 20.0;   ///< [m], farther returns are left out: what is left of the tilt's error blurs them.
  int every_nth_sweep = 0;   ///< Every so many sweeps one is used; 0: those of clean keyframes.
  int max_voxels = 4000000;  ///< About 50 bytes each; a map that would hold more goes on with cubes twice the size.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("enabled", enabled);
    visit("voxel_size", voxel_size);
    visit("min_sweeps", min_sweeps);
    visit("min_range", min_range);
    visit("max_range", max_range);
    visit("every_nth_sweep", every_nth_sweep);
    visit("max_voxels", max_voxels);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_CLOUD_OPTIONS_H_
