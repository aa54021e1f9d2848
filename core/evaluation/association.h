#ifndef ARBORSLAM_CORE_EVALUATION_ASSOCIATION_H_
#define ARBORSLAM_CORE_EVALUATION_ASSOCIATION_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/sensor/trajectory3.h"

namespace arborslam {

/// How the poses of an estimate find their partners in a reference.
struct AssociationOptions {
  /// [s], >= 0. An estimate's pose and the reference's pose nearest to it in time are a pair if their stamps differ by
  /// no more than this.
  double max_time_difference = 0.02;
  /// [s], >= 0. Where two neighbouring poses of the reference are no further apart than this, a pose of the estimate
  /// between them is paired with the pose interpolated at its own stamp instead (straight line, constant rotation
  /// rate). 0: never interpolate.
  double max_interpolation_gap = 0.0;

  /// Empty if the options can be used, otherwise what is wrong with them.
  std::string Validate() const;
};

/// An estimated pose and the true one at the same time, each in the frame of its own trajectory.
struct PosePair {
  StampedPose3 estimate;
  StampedPose3 reference;
};

/// Which poses belong together.
struct AssociationResult {
  std::vector<PosePair> pairs;     ///< In the order of the estimate's stamps; never empty.
  bool has_headings = false;       ///< True if estimate and reference both have orientations.
  size_t unmatched_estimate = 0;   ///< Poses of the estimate without a partner.
  size_t unmatched_reference = 0;  ///< Poses of the reference that no pair made use of.
};

/// Pairs the poses of `estimate` with those of `reference` by their stamps; neither needs to be in order. A pose of the
/// reference that is not interpolated serves one pose of the estimate only, the nearest in time (of two as near, the
/// earlier).
/// @param place names the two trajectories in errors, such as by their files.
/// Throws `UserError` when a trajectory is empty or has a value that is not finite, a coordinate
/// beyond 1e9 m or a null quaternion, and when nothing matches (the
/// message gives both time ranges), and `std::invalid_argument` when the options are not valid.
AssociationResult Associate(const Trajectory3& estimate, const Trajectory3& reference,
                            const AssociationOptions& options, const std::string& place);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_EVALUATION_ASSOCIATION_H_
