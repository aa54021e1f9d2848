#ifndef ARBORSLAM_CORE_IO_PULLALLY_H_
#define ARBORSLAM_CORE_IO_PULLALLY_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/io/npz.h"
#include "core/io/scan_source.h"

namespace arborslam {

/// The recordings of the Pullally orchard that accompany Nazate-Burgos et al. 2026 (RAL-UC/RoSA_SLAM on GitHub), and
/// any NumPy zip laid out alike. Two of its arrays are read, no other ever (most are derived from the ground truth):
///
///   scan0  N x B, ranges [m], N >= 1 scans of B >= 2 beams; bearing_i = -pi + i 2 pi / (B + 1). A range that is
///   infinite,
///          not a number or negative means that nothing came back.
///   time   N or N x 1, stamps, the middle of each sweep, as `RepairStamps` takes them. When it is absent, scan i is
///          stamped i * 1 s.
///
/// The ranges are unpacked at opening: 4 bytes each.
class PullallyScanSource : public ScanSource {
 public:
  /// Throws `UserError` when the file cannot be read or its arrays are not as above.
  explicit PullallyScanSource(const std::string& path);

  std::optional<Scan> Next() override;
  std::optional<size_t> NumScans() const override { return stamps_.size(); }
  const std::vector<std::string>& Notices() const override { return notices_; }

 private:
  std::vector<double> stamps_;
  std::vector<float> ranges_;  // N x num_beams_, row-major.
  size_t num_beams_ = 0;
  size_t next_ = 0;
  std::vector<std::string> notices_;
};

/// The stamps of the `count` records of a Pullally recording as they are: its array `time`, or nothing when it has
/// none. Throws `UserError` on a wrong shape.
std::optional<std::vector<double>> ReadPullallyStamps(const NpzFile& file, size_t count);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_PULLALLY_H_
