#ifndef ARBORSLAM_CORE_IO_SWEEP_FOLDER_H_
#define ARBORSLAM_CORE_IO_SWEEP_FOLDER_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/io/scan_source.h"
#include "core/io/sweep_folder_options.h"

namespace arborslam {

/// A recording of 3D sweeps, one a file: KITTI `.bin` (`ReadKittiBin`).
///
/// The files, all of one kind, lie in the given folder or in `clouds`, `velodyne` or `velodyne_points/data` below it,
/// and are taken in natural order of their names (`NaturallyLess`), hidden ones left aside.
///
/// Their stamps come from the first of these that there is:
///   1. `timestamps.txt` or `times.txt`, one stamp for each file (`ReadSweepStamps`): with the sweeps, in a folder from
///      there up to the given one, or, when the sweeps lie in the given folder itself, in its parent;
///   2. the names of the files (`StampsOfNames`; the order is that of the stamps then);
///   3. the place in the order, at 10 Hz from 0.
/// A stamp names the start of its sweep unless `SweepFolderOptions::stamp` says otherwise.
///
/// A sweep lasts as long as `SweepFolderOptions::sweep_duration` says, else as its stamps tell
/// (`SweepDurationFromStamps`).
///
/// One sweep is in memory at a time. Sweeps without points and sweeps whose stamp is not later than the one before are
/// given like all others.
class SweepFolder : public ScanSource {
 public:
  /// Opens the recording at `path`, a folder or one file. Throws `UserError` when there are no sweeps, when they are of
  /// more than one kind, when the stamps are malformed or not as many as the files, and when the first file is damaged.
  SweepFolder(const std::string& path, const SweepFolderOptions& options);

  /// Throws `UserError` when the next file is damaged or has gone.
  std::optional<Scan> Next() override;
  std::optional<size_t> NumScans() const override { return files_.size(); }
  const std::vector<std::string>& Notices() const override { return notices_; }

  /// True if `path` is a folder with sweeps or a file of a kind that holds a sweep.
  static bool Recognises(const std::string& path);

 private:
  void ReadStamps(const std::string& stamps_path);
  void FindDuration();

  SweepFolderOptions options_;
  std::vector<std::string> files_;
  std::vector<double> stamps_;  // [s], one a file.
  double duration_ = 0.0;       // [s]
  size_t next_ = 0;
  std::vector<std::string> notices_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SWEEP_FOLDER_H_
