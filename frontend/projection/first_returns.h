#ifndef ARBORSLAM_FRONTEND_PROJECTION_FIRST_RETURNS_H_
#define ARBORSLAM_FRONTEND_PROJECTION_FIRST_RETURNS_H_

#include <Eigen/Core>
#include <array>

#include "core/sensor/planar_scan.h"

namespace arborslam {

/// What a scan says about a place.
enum class Sight {
  kUnknown,   ///< No ray of a known end went there.
  kHidden,    ///< Something stands in front of it.
  kOccupied,  ///< Something stands there.
  kFree,      ///< Rays passed it and ended clearly behind.
};

/// A scan as seen from its sensor: how far one can look in every direction.
class FirstReturns {
 public:
  /// Of a scan that saw nothing.
  FirstReturns() : FirstReturns(PlanarScan()) {}
  explicit FirstReturns(const PlanarScan& scan);

  /// What the scan says about `place` [m, base frame of the scan]. "Clearly" is `range_margin` [m] along the ray; a
  /// return up to `side_margin` [m] beside the ray counts as on it, so that the edge of a trunk is not looked past.
  Sight Look(const Eigen::Vector2f& place, float range_margin, float side_margin) const;

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(first_, free_);
  }

 private:
  static constexpr int kSectors = 360;

  // [m], of the first return of each sector; infinite where there is none.
  std::array<float, kSectors> first_;
  // [m], how far each sector is known to be free; 0 where nothing is known.
  std::array<float, kSectors> free_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_FIRST_RETURNS_H_
