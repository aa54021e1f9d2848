#ifndef ARBORSLAM_APPS_EVALUATE_OFFLINE_SUMMARY_H_
#define ARBORSLAM_APPS_EVALUATE_OFFLINE_SUMMARY_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace arborslam {

/// Reads the summary.json of arborslam_offline. Throws `UserError` when it is none: not JSON, or without one of the
/// figures below that every run has.
nlohmann::json ReadOfflineSummary(const std::string& path);

/// How a figure of a summary.json is presented.
struct OfflineField {
  const char* key;      ///< For machines, with the unit: "scan_time_median_ms".
  const char* name;     ///< For people: "time a scan, median".
  const char* heading;  ///< For narrow columns: "t_med".
  const char* unit;     ///< "m", "ms", "MiB", "%" or "".
  int decimals;         ///< To be printed.
  /// Of what `ReadOfflineSummary` returned; absent when the run was not compared with a reference.
  std::optional<double> (*value)(const nlohmann::json& summary);
};

/// The error of the causal trajectory, times, memory, loops and shares of scans that could not be matched or had a
/// direction without hold. Shares are of the scans that got a pose.
const std::vector<OfflineField>& OfflineFields();

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_EVALUATE_OFFLINE_SUMMARY_H_
