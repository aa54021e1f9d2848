#ifndef ARBORSLAM_CORE_IO_CARMEN_H_
#define ARBORSLAM_CORE_IO_CARMEN_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/io/scan_source.h"
#include "core/io/text_reader.h"

namespace arborslam {

/// Logs of the CARMEN toolkit (Montemerlo et al. 2003), as of the RADISH repository: a message a line, `#` comments.
///
///   FLASER n r_1 ... r_n x y theta odom_x odom_y odom_theta stamp host logger_stamp
///          A half circle ahead: bearing_i = -90 deg + i 180 deg / n, or / (n - 1) when n is odd.
///   ROBOTLASER1 type start_angle field_of_view resolution maximum_range accuracy remission_mode n r_1 ... r_n
///          m remission_1 ... remission_m x y theta odom_x odom_y odom_theta tv rv forward_safety side_safety turn_axis
///          stamp host logger_stamp
///   ODOM x y theta tv rv acceleration stamp host logger_stamp
///
/// Units m, rad, s. Other messages are passed over. Of a log that has its scans as FLASER and as ROBOTLASER1, the kind
/// with more messages is read. `stamp` is taken for the middle of the sweep.
///
/// No return: a range of 81.82 m and more (the error codes of SICK scanners) or infinite; at or over a ROBOTLASER1's
/// maximum range; and the greatest range of all FLASER messages when it stands out by how often it occurs, as the range
/// that a driver cuts at does.
///
/// Odometry: x y theta, the lidar in the frame of the wheels. Where its place on the robot (odom_x odom_y odom_theta)
/// changes, someone has corrected the one or the other; then the robot's pose is taken for the lidar's. Many loggers
/// write the pose of the last ODOM message, which is some time older than the scan, and some write none: where nine in
/// ten lines repeat that message, or no pose on the lines ever changes, the ODOM messages before and after a line are
/// interpolated at its stamp instead. A log in which nothing moves has no odometry.
///
/// The file is read twice: at opening for stamps and poses, 100 bytes a scan, and once more scan by scan. Stamps that
/// run backwards are mended as by `MakeRising`: no scan is lost. A last line that is cut short, as when a logger was
/// stopped, is left out.
class CarmenScanSource : public ScanSource {
 public:
  /// True if the file is called *.clf or *.carmen, or a message of those above or a PARAM or SYNC is among its first
  /// lines. False for what cannot be read.
  static bool Recognises(const std::string& path);

  /// Throws `UserError`, naming the line, for a message above with a wrong number of fields, a field that is no finite
  /// number, a negative range, and a coordinate beyond 1e9 m; and for a log without scans.
  explicit CarmenScanSource(const std::string& path);

  std::optional<Scan> Next() override;
  std::optional<size_t> NumScans() const override { return stamps_.size(); }
  const std::vector<std::string>& Notices() const override { return notices_; }

 private:
  std::string tag_;  // Of the messages that are read as scans.
  std::vector<double> stamps_;
  std::vector<SE2> odometry_;  // One per scan, or none at all.
  float no_return_;            // [m], FLASER: from this range on nothing came back.
  std::vector<std::string> notices_;
  TextReader reader_;
  size_t next_ = 0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_CARMEN_H_
