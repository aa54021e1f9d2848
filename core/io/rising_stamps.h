#ifndef ARBORSLAM_CORE_IO_RISING_STAMPS_H_
#define ARBORSLAM_CORE_IO_RISING_STAMPS_H_

#include <cstddef>
#include <vector>

namespace arborslam {

/// Stamps that rise from record to record, and how they came about.
struct RisingStamps {
  std::vector<double> stamps;  ///< [s]
  size_t num_backwards = 0;    ///< Of the stamps as given: not later than the one before by a microsecond.
  size_t num_changed = 0;
};

/// The stamps [s, finite] of a recording whose records are in their true order while some clock readings are not: makes
/// them rise with the fewest changes. The longest rising sequence keeps its stamps to the bit; what lies between two of
/// these is spread evenly, and what lies before the first or after the last of them goes on by the median step (1 s
/// where there is none). So one reading that ran ahead is corrected, not the many right ones that follow it.
RisingStamps MakeRising(std::vector<double> stamps);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_RISING_STAMPS_H_
