#ifndef ARBORSLAM_APPS_OFFLINE_RUN_FIGURES_H_
#define ARBORSLAM_APPS_OFFLINE_RUN_FIGURES_H_

#include <cstddef>
#include <functional>
#include <vector>

#include "apps/offline/summary.h"

namespace arborslam {

/// "matched", "rejected" or "skipped".
const char* ToString(ScanStatus status);

/// "measured", "interpolated" or "left out".
const char* ToString(PoseSource source);

/// The places in the recording, from 0 on, of the scans that have a pose.
std::vector<size_t> PosedIndices(const RunRecord& record);

/// How many of a run's scans and loops came to what.
struct RunCounts {
  size_t matched = 0;
  size_t rejected = 0;
  size_t skipped = 0;
  size_t spoilt = 0;  ///< Matched keyframes that were too unclean to become part of the maps.
  size_t keyframes = 0;
  size_t searched_wide = 0;
  size_t degenerate = 0;
  size_t loops_accepted = 0;
};

RunCounts CountRun(const RunRecord& record);

/// A stage that every scan goes through.
struct StageField {
  const char* key;              ///< "match".
  const char* name;             ///< For people: "prediction, search, refinement".
  double ScanResult::*time_ms;  ///< [ms]
};

/// The stages, in their order.
const std::vector<StageField>& StageFields();

/// [ms], all stages of a scan.
double TotalMs(const ScanResult& scan);

/// `field` (a member, or a function of a scan) of every scan that has a pose.
template <class Field>
std::vector<double> OverPosedScans(const RunRecord& record, const Field& field) {
  std::vector<double> values;
  for (const ScanResult& scan : record.scans) {
    if (scan.status != ScanStatus::kSkipped) values.push_back(std::invoke(field, scan));
  }
  return values;
}

/// The value that `share`, in [0, 1], of `values` do not exceed; 0 if there are none.
double Percentile(std::vector<double> values, double share);

/// Scans in a row whose match was degenerate.
struct DegenerateStretch {
  size_t first = 0;       ///< Index of the first scan,
  size_t last = 0;        ///< and of the last one.
  double length_m = 0.0;  ///< [m] of the causal path between these two.
};

/// In the order of the scans.
std::vector<DegenerateStretch> DegenerateStretches(const RunRecord& record);

/// [MiB], the most memory that the process has had so far.
double PeakMemoryMib();

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_RUN_FIGURES_H_
