#ifndef ARBORSLAM_CORE_IO_STAMP_REPAIR_H_
#define ARBORSLAM_CORE_IO_STAMP_REPAIR_H_

#include <string>
#include <vector>

namespace arborslam {

/// Stamps that rise from record to record, in seconds.
struct RepairedStamps {
  std::vector<double> seconds;
  std::vector<std::string> notices;  ///< What was done, full sentences; empty if nothing was.
};

/// The stamps of a recording whose records are in their true order, as a clock should have given them. No single value
/// decides:
/// - their unit, of seconds, milli-, micro- and nanoseconds: that in which most lie between the years 2000 and 2100;
///   of whole numbers that count from a moment of their own, the greatest in which the median step is at most a minute;
/// - stamps that say nothing (not finite, beyond 1e12 s, all alike, in steps of less than a microsecond) are replaced:
///   the records are `usual_step` [s] apart;
/// - a clock that was set back or rolled over (weeks of GPS): what follows keeps its steps and goes on after the median
///   step;
/// - single readings that repeat or run back or ahead of those that follow: as few as possible are replaced by ones
///   between their neighbours' (`MakeRising`), so that stamps of a coarse clock are spread evenly.
/// A pause stays one. Stamps that are right are returned to the bit.
RepairedStamps RepairStamps(std::vector<double> stamps, double usual_step);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_STAMP_REPAIR_H_
