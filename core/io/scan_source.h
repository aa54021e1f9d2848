#ifndef ARBORSLAM_CORE_IO_SCAN_SOURCE_H_
#define ARBORSLAM_CORE_IO_SCAN_SOURCE_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/io/sweep_folder_options.h"
#include "core/sensor/laser_scan.h"
#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// What a recording is made of: scans in a plane or sweeps in space. A recording holds one kind only.
using Scan = std::variant<LaserScan, LidarSweep>;

/// A recording that gives its scans one at a time, in the order of the file.
class ScanSource {
 public:
  virtual ~ScanSource() = default;

  /// The next scan, or nothing at the end. Throws `UserError` when the record is damaged.
  virtual std::optional<Scan> Next() = 0;

  /// How many scans the recording holds, where the format tells.
  virtual std::optional<size_t> NumScans() const = 0;

  /// What a user should know about the recording (a missing field, an assumption made): full sentences, found at
  /// opening.
  virtual const std::vector<std::string>& Notices() const = 0;
};

/// Opens the recording at `path`, its format told from its content and name; `options` is for sweeps in files. Throws
/// `UserError` when the path does not exist, cannot be read, or holds no known format.
std::unique_ptr<ScanSource> OpenScanSource(const std::string& path, const SweepFolderOptions& options = {});

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SCAN_SOURCE_H_
