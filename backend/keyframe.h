#ifndef ARBORSLAM_BACKEND_KEYFRAME_H_
#define ARBORSLAM_BACKEND_KEYFRAME_H_

#include <vector>

#include "core/io/value_store.h"
#include "core/map/ids.h"
#include "core/sensor/planar_scan.h"

namespace arborslam {

/// A scan that is kept, as a variable of the estimation.
struct Keyframe {
  KeyframeId id;
  Stored<PlanarScan> scan;
  bool is_inserted = false;  ///< Clean enough to be part of the maps.
};

/// Makes all scans later by `shift` [s].
void ShiftStamps(double shift, std::vector<Keyframe>* keyframes);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_KEYFRAME_H_
