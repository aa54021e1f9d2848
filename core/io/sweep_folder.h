#ifndef ARBORSLAM_CORE_IO_SWEEP_FOLDER_H_
#define ARBORSLAM_CORE_IO_SWEEP_FOLDER_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/io/bin_layout.h"
#include "core/io/point_times.h"
#include "core/io/scan_source.h"
#include "core/io/sweep_folder_options.h"

namespace arborslam {

/// A recording of 3D sweeps, one a file: KITTI `.bin` (`ReadKittiBin`), `.pcd` or `.ply` (`ReadPointCloudFile`).
///
/// The files, all of one kind, lie in `clouds`, `velodyne` or `velodyne_points/data` below the given folder or in that
/// folder itself (the first of these that has any), and are taken in natural order of their names (`NaturallyLess`), or
/// of the stamps that these are (`StampsOfNames`); hidden files are left aside.
///
/// Their stamps come from the first of these that there is:
///   1. `timestamps.txt` or `times.txt`, one stamp for each file (`ReadSweepStamps`): with the sweeps, in a folder from
///      there up to the given one, or, when the sweeps lie in the given folder itself, in its parent;
///   2. the names of the files;
///   3. the times of the points when they are absolute: the stamp is the sweep's first, whatever the options say;
///   4. the place in the order, from 0: each as long after the one before as its points' times span, or 0.1 s.
/// A stamp names the start of its sweep unless `SweepFolderOptions::stamp` says otherwise.
///
/// Times of points are taken as `FindPointTimeFormat` finds them in the first files. Relative ones, and absolute ones
/// on the clock of the stamps, count from the stamp, so that a sweep whose times are negative began before its stamp;
/// others, and all when the stamp is said to be the middle or the end, from the sweep's first point. A sweep whose
/// times span more than three sweeps is given without.
///
/// A sweep lasts as long as `SweepFolderOptions::sweep_duration` says; else as its points' times span, or a step of the
/// stamps where that is little longer (a lidar that turns without a pause and misses returns at the ends); without
/// times as the stamps tell (`SweepDurationFromStamps`), and if they do not, its duration is a mere guess. It lasts
/// longer where its own times do.
///
/// One sweep is in memory at a time. Sweeps without points and sweeps whose stamp is not later than the one before are
/// given like all others.
class SweepFolder : public ScanSource {
 public:
  /// Opens the recording at `path`, a folder or one file. Throws `UserError` when there are no sweeps, when they are of
  /// more than one kind, when the stamps are malformed or not as many as the files, and when all of the first ten files
  /// are damaged.
  SweepFolder(const std::string& path, const SweepFolderOptions& options);

  /// A file that is damaged or has gone is given as a sweep without points, with its fault.
  std::optional<Scan> Next() override;
  std::optional<size_t> NumScans() const override { return files_.size(); }
  const std::vector<std::string>& Notices() const override { return notices_; }

  /// True if `path` is a folder with sweeps, or a file that is one by its content or, for KITTI's, by its name.
  static bool Recognises(const std::string& path);

 private:
  // What the times of the points count from.
  enum class PointClock {
    kNone,       // They are not used.
    kFromStamp,  // The stamp.
    kOfStamps,   // What the stamps count from.
    kOther
  };

  // Returns the path of the file of stamps, or "".
  std::string FindFiles(const std::string& path);
  void FindStamps(const std::string& stamp_file);
  // Of .bin files.
  void FindLayout();
  // Takes the stamps of the files, as they are in the recording.
  void TakeStamps(std::vector<double> stamps);
  // Returns the stamps of the names, [s], or none when they are no stamps.
  std::vector<double> SortByStampsOfNames();
  void FindPointTimes();
  void AssumeStamps(double step);
  void FindDuration(double span);

  SweepFolderOptions options_;
  std::vector<std::string> files_;
  BinLayout layout_;            // Of .bin files.
  std::vector<double> stamps_;  // [s], one a file; empty when the times of the points tell them.
  PointClock point_clock_ = PointClock::kNone;
  PointTimeFormat point_time_format_;
  double duration_ = 0.0;  // [s]
  double max_span_ = 0.0;  // [s], of the times of a sweep.
  bool is_duration_guessed_ = false;
  double next_start_ = 0.0;  // [s], of a sweep without stamp and times.
  size_t next_ = 0;
  std::vector<std::string> notices_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SWEEP_FOLDER_H_
