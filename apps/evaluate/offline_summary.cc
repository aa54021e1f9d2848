#include "apps/evaluate/offline_summary.h"

#include <fstream>

#include "core/error.h"
#include "core/io/input_file.h"

namespace arborslam {
namespace {

using Json = nlohmann::json;
using Pointer = Json::json_pointer;

// What every summary has as a number.
constexpr const char* kRequired[] = {"/scans/matched",         "/scans/rejected",  "/scans/degenerate",
                                     "/loops/accepted",        "/peak_memory_mib", "/time_ms/scan_total/median",
                                     "/time_ms/scan_total/p95"};

std::optional<double> NumberAt(const Json& summary, const char* path) {
  const Pointer pointer(path);
  if (!summary.contains(pointer) || !summary.at(pointer).is_number()) return std::nullopt;
  return summary.at(pointer).get<double>();
}

std::optional<double> PercentOfPosedScans(const Json& summary, const char* path) {
  const double posed = *NumberAt(summary, "/scans/matched") + *NumberAt(summary, "/scans/rejected");
  if (posed <= 0.0) return std::nullopt;
  return 100.0 * *NumberAt(summary, path) / posed;
}

}  // namespace

Json ReadOfflineSummary(const std::string& path) {
  std::ifstream stream = OpenInputFile(path);
  Json summary = Json::parse(stream, nullptr, /*allow_exceptions=*/false);
  if (!summary.is_object()) throw UserError(path, "is not JSON", "give the summary.json of arborslam_offline");
  for (const char* required : kRequired) {
    if (!NumberAt(summary, required)) {
      throw UserError(path, std::string("has no number at ") + required,
                      "give the summary.json of this version's arborslam_offline");
    }
  }
  return summary;
}

const std::vector<OfflineField>& OfflineFields() {
  static const std::vector<OfflineField> fields = {
      {"odometry_ate_se2_rmse_m", "causal trajectory: ATE after SE(2) alignment, RMSE", "odo_ATE", "m", 4,
       [](const Json& s) { return NumberAt(s, "/errors/odometry/ate_se2_rmse_m"); }},
      {"scan_time_median_ms", "time a scan, median", "t_med", "ms", 2,
       [](const Json& s) { return NumberAt(s, "/time_ms/scan_total/median"); }},
      {"scan_time_p95_ms", "time a scan, 95 % of scans below", "t_p95", "ms", 2,
       [](const Json& s) { return NumberAt(s, "/time_ms/scan_total/p95"); }},
      {"peak_memory_mib", "peak memory", "memory", "MiB", 1,
       [](const Json& s) { return NumberAt(s, "/peak_memory_mib"); }},
      {"rejected_percent", "scans rejected", "reject", "%", 2,
       [](const Json& s) { return PercentOfPosedScans(s, "/scans/rejected"); }},
      {"degenerate_percent", "scans with a direction that nothing held", "degen", "%", 2,
       [](const Json& s) { return PercentOfPosedScans(s, "/scans/degenerate"); }},
      {"loops_accepted", "loops accepted", "loops", "", 0,
       [](const Json& s) { return NumberAt(s, "/loops/accepted"); }},
  };
  return fields;
}

}  // namespace arborslam
