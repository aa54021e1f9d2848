#ifndef ARBORSLAM_CORE_IO_SWEEP_STAMPS_H_
#define ARBORSLAM_CORE_IO_SWEEP_STAMPS_H_

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace arborslam {

/// The stamps of a recording.
struct SweepStamps {
  std::vector<double> seconds;       ///< [s], finite.
  std::vector<size_t> line_numbers;  ///< The line of each in the file that it comes from, counted from 1.
};

/// A stamp [s] from a number in text. Seconds, unless the number lies between the years 2000 and 2100 when it is
/// counted in milli-, micro- or nanoseconds since 1970: then it is. Nothing when `text` is no finite number.
std::optional<double> ParseStamp(std::string_view text);

/// Reads a file of stamps, one a line, '#' before a comment: a number as `ParseStamp` takes it, or a date and a time of
/// day as KITTI's raw recordings have them ("2011-09-26 13:02:25.964389445", taken as UTC, given in seconds since
/// 1970). Throws `UserError` naming the line that is neither.
SweepStamps ReadSweepStamps(const std::string& path);

/// The stamps [s] that the file names `stems` (without extension) end with, if every one does and no two are alike:
///   - seconds, milli-, micro- or nanoseconds since 1970, between the years 2000 and 2100, with or without a fraction,
///   - seconds and nanoseconds since 1970 in the same years, apart by '_' or '-', or
///   - seconds from any epoch with a fraction of three digits or more, when no digit comes before. Fractions that are
///     nanoseconds without the zeros in front are read as such where that makes the steps more even.
/// Nothing otherwise: the names are mere numbers then.
std::optional<std::vector<double>> StampsOfNames(const std::vector<std::string>& stems);

/// How long a sweep lasts, as far as the stamps of a recording tell.
struct SweepDuration {
  double seconds = 0.1;
  bool is_assumed = true;    ///< The stamps do not tell; `seconds` is that of a usual lidar at 10 Hz.
  double median_step = 0.0;  ///< [s], from stamp to later stamp; 0 when there is none.
};

/// The median step between stamps [s] is the duration of a sweep, for a spinning lidar measures without a pause. No
/// usual one turns slower than 5 Hz: when the median is over 0.21 s, sweeps were left out of the recording, the real
/// duration cannot be told from the stamps, and 0.1 s is assumed; so too without a step. Steps that do not rise are
/// left aside.
SweepDuration SweepDurationFromStamps(const std::vector<double>& stamps);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_SWEEP_STAMPS_H_
