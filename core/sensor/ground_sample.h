#ifndef ARBORSLAM_CORE_SENSOR_GROUND_SAMPLE_H_
#define ARBORSLAM_CORE_SENSOR_GROUND_SAMPLE_H_

#include <Eigen/Core>

namespace arborslam {

/// A patch of ground that a sweep saw: the mean of the returns of one cell.
struct GroundSample {
  Eigen::Vector3f position;  ///< [m], in the frame that the sample's user says.
  float weight = 1.0f;       ///< Number of returns.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(position, weight);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_SENSOR_GROUND_SAMPLE_H_
