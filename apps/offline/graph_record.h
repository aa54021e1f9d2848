#ifndef ARBORSLAM_APPS_OFFLINE_GRAPH_RECORD_H_
#define ARBORSLAM_APPS_OFFLINE_GRAPH_RECORD_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "backend/graph/graph_smoother.h"
#include "core/evaluation/trajectory_metrics.h"

namespace arborslam {

/// A graph's errors against its true poses, SE(2)-aligned.
struct GraphErrors {
  TrajectoryEvaluation smoothed;
  TrajectoryEvaluation given;     ///< The vertices as they were in the file.
  size_t unmatched_vertices = 0;  ///< Without a true pose.
};

/// All that is told of the smoothing of a graph.
struct GraphRecord {
  std::string input;
  int num_threads = 1;
  bool robust = true;
  std::vector<std::string> notices;
  SmoothedGraph smoothed;
  double read_ms = 0.0;   ///< [ms]
  double solve_ms = 0.0;  ///< [ms], from the graph as read to the graph as written.
  std::optional<GraphErrors> errors;
};

/// summary.json of such a run (its keys carry their units): counts, parts, costs, every loop dropped, times, peak
/// memory and the errors if there was a reference.
std::string GraphSummaryJson(const GraphRecord& record);

/// The same in a few lines for people.
std::string GraphSummaryText(const GraphRecord& record);

/// The same as one HTML file that asks for no other, with a picture (the bytes of a PNG) and the configuration.
std::string GraphReportHtml(const GraphRecord& record, const std::string& picture, const std::string& effective_config);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_GRAPH_RECORD_H_
