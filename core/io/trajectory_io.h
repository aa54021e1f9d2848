#ifndef ARBORSLAM_CORE_IO_TRAJECTORY_IO_H_
#define ARBORSLAM_CORE_IO_TRAJECTORY_IO_H_

#include <string>

#include "core/sensor/stamped_pose.h"
#include "core/sensor/trajectory3.h"

namespace arborslam {

/// In which frame the reference of a Pullally recording is wanted.
enum class ReferenceFrame {
  kOfRun,  ///< `gnss_rotated_c`: from the first position, which is the origin, about +x. One for each recording.
  kOfSite  ///< `gnss_data`: UTM east and north. The same for all recordings.
};

/// Reads a trajectory, its format told from the content:
///
///   TUM text   lines `stamp x y z qx qy qz qw` [s, m], '#' before a comment. A quaternion is normalised when its norm
///   is
///              within 1 % of 1 and refused otherwise.
///   NumPy zip  a Pullally recording's reference: `gnss_rotated_c`, N x 2, x and y [m], or `gnss_data`, N x 2 or more,
///              east and north [m], as `frame` says; stamped by `time` (by the index [s] when that is absent, as its
///              scans are). For evaluation only, never an input of the method.
///
/// Throws `UserError` naming line or record when the file cannot be read, a value is not finite, a line has too few or
/// too many columns, the stamps do not increase, or there is no pose at all.
Trajectory3 ReadTrajectory(const std::string& path, ReferenceFrame frame = ReferenceFrame::kOfRun);

/// What the stamps of a trajectory are, for the comment in its file.
constexpr char kStampOfSweep[] = "middle of sweep [s]";

/// Writes `trajectory` in TUM format, stamps with 9 decimals, a comment with frames and units first. All values must be
/// finite. Throws `UserError` when the file cannot be written.
void WriteTum(const std::string& path, const Trajectory3& trajectory, const std::string& stamp = kStampOfSweep);

/// The same for a planar trajectory, with z = 0.
void WriteTum(const std::string& path, const Trajectory& trajectory, const std::string& stamp = kStampOfSweep);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_TRAJECTORY_IO_H_
