#ifndef ARBORSLAM_APPS_OFFLINE_HTML_REPORT_H_
#define ARBORSLAM_APPS_OFFLINE_HTML_REPORT_H_

#include <string>
#include <vector>

#include "apps/offline/summary.h"
#include "core/io/map_io.h"
#include "core/map/submap.h"
#include "core/sensor/trajectory3.h"

namespace arborslam {

/// A limit that the score of a scan is held to.
struct ScoreGate {
  double score = 0.0;  ///< [m]
  std::string label;   ///< What happens above it.
};

/// What the report is about; what is referred to must outlive the call. Whatever is empty or null has no place in it.
struct ReportInput {
  const RunRecord& record;
  const std::vector<Submap>& submaps;
  const std::string& effective_config;
  const GridImage* map = nullptr;
  /// T_map_base of the record's scans that have a pose, in their order. Roll, pitch and height are shown if any is not
  /// 0.
  Trajectory3 trajectory;
  Trajectory3 odometry;  ///< The causal estimate, likewise.
  std::vector<ScoreGate> score_gates;
};

/// A run for the browser: one HTML file that asks for no other. It shows the paths on the map, the errors along the way
/// if the record has any, score and verdict of every scan, all loops, times, what was not used and why, and the
/// configuration. Any text, such as the name of a file, is shown as it is and never run.
std::string HtmlReport(const ReportInput& input);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_HTML_REPORT_H_
