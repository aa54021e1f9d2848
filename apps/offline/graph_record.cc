#include "apps/offline/graph_record.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/common/error_json.h"
#include "apps/common/version.h"
#include "apps/offline/html_text.h"
#include "apps/offline/run_figures.h"

namespace arborslam {
namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kMaxLoopsInReport = 1000;

std::string ShortNumber(double value) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

Json Errors(const TrajectoryEvaluation& evaluation) { return ErrorsJson(evaluation.alignment, evaluation.metrics); }

const char* StartText(const SmoothedGraph& smoothed) {
  return smoothed.started_from_edges ? "the edges, orientations first" : "the vertices as given";
}

// Figures by name, for people.
std::vector<std::pair<std::string, std::string>> Figures(const GraphRecord& record) {
  const SmoothedGraph& smoothed = record.smoothed;
  const size_t num_dropped = smoothed.dropped_loops.size();
  std::vector<std::pair<std::string, std::string>> figures{
      {"vertices", std::to_string(smoothed.graph.vertices.size())},
      {"edges", std::to_string(smoothed.graph.edges.size() + num_dropped)},
      {"loops dropped", std::to_string(num_dropped) + " of " + std::to_string(smoothed.num_loops) +
                            (record.robust ? "" : " (smoothing.robust is off)")},
      {"parts", std::to_string(smoothed.num_parts)},
      {"chi2 as given", ShortNumber(smoothed.initial_chi2)},
      {"chi2 smoothed", ShortNumber(smoothed.final_chi2)},
      {"started from", StartText(smoothed)},
      {"steps", std::to_string(smoothed.iterations)},
      {"time for reading", ShortNumber(record.read_ms / 1000.0) + " s"},
      {"time for smoothing", ShortNumber(record.solve_ms / 1000.0) + " s"},
      {"peak memory", ShortNumber(PeakMemoryMib()) + " MiB"}};
  if (record.errors) {
    figures.emplace_back("ATE RMSE as given", ShortNumber(record.errors->given.metrics.ate_rmse) + " m");
    figures.emplace_back("ATE RMSE smoothed", ShortNumber(record.errors->smoothed.metrics.ate_rmse) + " m");
  }
  return figures;
}

constexpr char kStyle[] = R"(
body { font: 16px/1.5 sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; color: #222; background: #fff; }
table { border-collapse: collapse; } td, th { padding: .2rem 1rem .2rem 0; text-align: left; }
img { max-width: 100%; border: 1px solid #ddd; } pre { overflow: auto; background: #f5f5f5; padding: 1rem; }
.notice { background: #fff4d6; padding: .5rem 1rem; }
)";

}  // namespace

std::string GraphSummaryJson(const GraphRecord& record) {
  const SmoothedGraph& smoothed = record.smoothed;
  const size_t num_edges = smoothed.graph.edges.size() + smoothed.dropped_loops.size();
  Json summary;
  summary["program"] = std::string("arborslam_offline ") + kVersion;
  summary["input"] = record.input;
  summary["threads"] = record.num_threads;
  summary["notices"] = record.notices;
  summary["graph"] = {{"vertices", smoothed.graph.vertices.size()},
                      {"edges", num_edges},
                      {"loops", smoothed.num_loops},
                      {"parts", smoothed.num_parts},
                      {"held", smoothed.held}};
  Json dropped = Json::array();
  for (const PoseGraph2::Edge& edge : smoothed.dropped_loops) dropped.push_back({{"from", edge.from}, {"to", edge.to}});
  summary["optimization"] = {{"robust", record.robust},
                             {"start", smoothed.started_from_edges ? "edges" : "vertices"},
                             {"initial_chi2", smoothed.initial_chi2},
                             {"final_chi2", smoothed.final_chi2},
                             {"iterations", smoothed.iterations},
                             {"loops_dropped", smoothed.dropped_loops.size()},
                             {"dropped", dropped}};
  summary["read_ms"] = record.read_ms;
  summary["solve_ms"] = record.solve_ms;
  summary["peak_memory_mib"] = PeakMemoryMib();
  if (record.errors) {
    summary["errors"] = {{"matched_vertices", record.errors->smoothed.aligned_pairs.size()},
                         {"unmatched_vertices", record.errors->unmatched_vertices},
                         {"trajectory", Errors(record.errors->smoothed)},
                         {"as_given", Errors(record.errors->given)}};
  }
  // Names of files may be of any bytes, JSON may not.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string GraphSummaryText(const GraphRecord& record) {
  std::string text;
  for (const auto& [name, value] : Figures(record)) text += name + ": " + value + "\n";
  return text;
}

std::string GraphReportHtml(const GraphRecord& record, const std::string& picture,
                            const std::string& effective_config) {
  const std::string name = ForHtml(std::filesystem::path(record.input).filename().string());
  std::ostringstream html;
  html << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\""
       << "Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">\n<title>"
       << name << " - Arbor SLAM report</title>\n<style>" << kStyle << "</style>\n</head>\n<body>\n<h1>" << name
       << "</h1>\n";
  for (const std::string& notice : record.notices) html << "<p class=\"notice\">" << ForHtml(notice) << "</p>\n";
  html << "<h2>Figures</h2>\n<table>\n";
  for (const auto& [figure, value] : Figures(record)) {
    html << "<tr><th>" << figure << "</th><td>" << ForHtml(value) << "</td></tr>\n";
  }
  html << "</table>\n<h2>Graph</h2>\n<p>Blue: edges along the order of the vertices; grey: loops; red: loops dropped; "
       << "green: vertices that are held.</p>\n<img alt=\"The smoothed graph from above\" src=\"data:image/png;base64,"
       << Base64(picture) << "\">\n";
  const std::vector<PoseGraph2::Edge>& dropped = record.smoothed.dropped_loops;
  if (!dropped.empty()) {
    html << "<h2>Loops dropped</h2>\n<table>\n<tr><th>from</th><th>to</th></tr>\n";
    for (size_t i = 0; i < std::min(dropped.size(), kMaxLoopsInReport); ++i) {
      html << "<tr><td>" << dropped[i].from << "</td><td>" << dropped[i].to << "</td></tr>\n";
    }
    html << "</table>\n";
    if (dropped.size() > kMaxLoopsInReport) {
      html << "<p>These are the first " << kMaxLoopsInReport << "; summary.json lists all.</p>\n";
    }
  }
  html << "<h2>Configuration</h2>\n<pre>" << ForHtml(effective_config) << "</pre>\n</body>\n</html>\n";
  return html.str();
}

}  // namespace arborslam
