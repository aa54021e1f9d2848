#ifndef ARBORSLAM_CORE_IO_POINT_TIMES_H_
#define ARBORSLAM_CORE_IO_POINT_TIMES_H_

#include <optional>
#include <string>
#include <vector>

namespace arborslam {

/// How the times of a recording's points are meant. Every driver has its own way: float32 or float64 seconds from the
/// sweep's stamp (`time`: Velodyne, LIO-SAM), uint32 nanoseconds from it (`t`: Ouster; `offset_time`: Livox), float64
/// seconds since 1970 or since the sensor was switched on (`timestamp`: Hesai, RoboSense), and microseconds of each.
struct PointTimeFormat {
  double unit = 1.0;         ///< [s]
  bool is_absolute = false;  ///< They count from a moment of their own, not from the stamp of the sweep.

  /// "seconds", "milliseconds", "microseconds" or "nanoseconds".
  std::string UnitName() const;
};

/// The format of the raw times of the points of one sweep, which lasts `sweep_duration` [s], roughly. The unit is the
/// one of seconds, milli-, micro- and nanoseconds in which the times span a thirtieth of that to thirty times that:
/// that is one at most. They are absolute when they lie farther from 0 than the sweep lasts twice. Nothing when no unit
/// fits, as when all are alike.
std::optional<PointTimeFormat> FindPointTimeFormat(const std::vector<double>& raw_times, double sweep_duration);

/// The earliest and the latest of the times of a sweep.
struct PointTimeSpan {
  double first = 0.0;  ///< [s], on the clock of the times.
  double last = 0.0;   ///< [s], likewise.
};

/// The span of `raw_times`, in any order; nothing when there are none or when it is over `max_span` [s]: such times are
/// damaged.
std::optional<PointTimeSpan> SpanOfPointTimes(const std::vector<double>& raw_times, const PointTimeFormat& format,
                                              double max_span);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_POINT_TIMES_H_
