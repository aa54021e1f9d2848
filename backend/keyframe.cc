#include "backend/keyframe.h"

#include <utility>

namespace arborslam {

void ShiftStamps(double shift, std::vector<Keyframe>* keyframes) {
  if (shift == 0.0) return;
  for (Keyframe& keyframe : *keyframes) {
    PlanarScan scan = *keyframe.scan.Get();
    scan.stamp += shift;
    keyframe.scan = keyframe.scan.Replaced(std::move(scan));
  }
}

}  // namespace arborslam
