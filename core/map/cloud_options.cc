#include "core/map/cloud_options.h"

#include "core/config/validation.h"

namespace arborslam {

std::string CloudOptions::Validate() const {
  if (!(voxel_size >= 0.01 && voxel_size <= 10.0)) return Violation("voxel_size", voxel_size, "lie in [0.01, 10] m");
  if (min_sweeps < 1) return Violation("min_sweeps", min_sweeps, "be at least 1");
  if (!(min_range >= 0.0)) return Violation("min_range", min_range, "be at least 0 m");
  if (!(max_range > min_range && max_range <= 1000.0)) {
    return Violation("max_range", max_range, "lie in (min_range, 1000] m");
  }
  if (every_nth_sweep < 0) return Violation("every_nth_sweep", every_nth_sweep, "be at least 0");
  if (max_voxels < 1000 || max_voxels > 1000000000) {
    return Violation("max_voxels", max_voxels, "lie in [1000, 1000000000]");
  }
  return "";
}

}  // namespace arborslam
