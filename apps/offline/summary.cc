#include "apps/offline/summary.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/common/version.h"

namespace arborslam {
namespace {

using Json = nlohmann::ordered_json;

const char* ToString(ScanStatus status) {
  switch (status) {
    case ScanStatus::kMatched:
      return "matched";
    case ScanStatus::kPredicted:
      return "rejected";
    case ScanStatus::kSkipped:
      return "skipped";
  }
  return "unknown";
}

size_t CountStatus(const RunRecord& record, ScanStatus status) {
  return static_cast<size_t>(std::count_if(record.scans.begin(), record.scans.end(),
                                           [status](const ScanResult& scan) { return scan.status == status; }));
}

size_t CountSpoilt(const RunRecord& record) {
  return static_cast<size_t>(std::count_if(record.scans.begin(), record.scans.end(), [](const ScanResult& scan) {
    return scan.status == ScanStatus::kMatched && scan.is_keyframe && !scan.is_inserted;
  }));
}

size_t CountAcceptedLoops(const RunRecord& record) {
  return static_cast<size_t>(std::count_if(record.finish.loops.begin(), record.finish.loops.end(),
                                           [](const LoopCandidate& loop) { return loop.accepted; }));
}

double TotalMs(const ScanResult& scan) { return scan.project_ms + scan.match_ms + scan.window_ms + scan.insert_ms; }

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto nth = values.begin() + static_cast<ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

template <class Value>
std::vector<double> OverPosedScans(const RunRecord& record, const Value& value) {
  std::vector<double> values;
  for (const ScanResult& scan : record.scans) {
    if (scan.status != ScanStatus::kSkipped) values.push_back(value(scan));
  }
  return values;
}

template <class Value>
Json Stage(const RunRecord& record, const Value& value) {
  const std::vector<double> values = OverPosedScans(record, value);
  return {{"median", Percentile(values, 0.5)}, {"p95", Percentile(values, 0.95)}, {"max", Percentile(values, 1.0)}};
}

Json Errors(const TrajectoryEvaluation& evaluation) {
  Json errors{{"alignment", ToString(evaluation.alignment)}};
  for (const MetricField& field : MetricFields()) {
    const std::optional<double> value = field.value(evaluation.metrics);
    if (value) errors[field.key] = *value;
  }
  return errors;
}

Json Optimization(const PoseGraphSummary& summary) {
  return {{"initial_cost", summary.initial_cost},
          {"final_cost", summary.final_cost},
          {"iterations", summary.iterations},
          {"loops_dropped", summary.dropped_loops.size()}};
}

double PeakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

std::string SummaryJson(const RunRecord& record) {
  Json summary;
  summary["program"] = std::string("arborslam_offline ") + kVersion;
  summary["input"] = record.input;
  summary["threads"] = record.num_threads;
  summary["odometry_only"] = record.odometry_only;
  summary["interrupted"] = record.is_interrupted;
  summary["notices"] = record.notices;

  const auto count = [&](auto has) { return std::count_if(record.scans.begin(), record.scans.end(), has); };
  summary["scans"] = {
      {"read", record.scans.size()},
      {"matched", CountStatus(record, ScanStatus::kMatched)},
      {"rejected", CountStatus(record, ScanStatus::kPredicted)},
      {"skipped", CountStatus(record, ScanStatus::kSkipped)},
      {"spoilt", CountSpoilt(record)},
      {"keyframes", count([](const ScanResult& scan) { return scan.is_keyframe; })},
      {"searched_wide", count([](const ScanResult& scan) { return scan.searched_wide; })},
      {"degenerate", count([](const ScanResult& scan) { return scan.match.verdict == MatchVerdict::kDegenerate; })}};
  Json unused = Json::array();
  for (size_t i = 0; i < record.scans.size(); ++i) {
    const ScanResult& scan = record.scans[i];
    if (scan.status == ScanStatus::kMatched) continue;
    unused.push_back({{"index", i},
                      {"stamp_s", scan.stamp},
                      {"status", ToString(scan.status)},
                      {"reason", scan.reason},
                      {"points", scan.match.num_points},
                      {"mhd_m", scan.match.score},
                      {"inlier_ratio", scan.match.inlier_ratio}});
  }
  summary["unused_scans"] = unused;

  summary["submaps"] = record.num_submaps;
  std::map<std::string, int> refused;
  Json candidates = Json::array();
  for (const LoopCandidate& loop : record.finish.loops) {
    if (!loop.accepted) ++refused[loop.reason];
    candidates.push_back({{"keyframe", loop.keyframe.value},
                          {"submap", loop.submap.value},
                          {"accepted", loop.accepted},
                          {"reason", loop.reason},
                          {"mhd_m", loop.match.score},
                          {"inlier_ratio", loop.match.inlier_ratio},
                          {"second_best_mhd_m", loop.match.second_score}});
  }
  summary["loops"] = {{"tried", record.finish.loops.size()},
                      {"accepted", CountAcceptedLoops(record)},
                      {"refused", refused},
                      {"optimization", Optimization(record.finish.loop_optimization)}};
  Json passes = Json::array();
  for (const PoseGraphSummary& pass : record.finish.refinements) passes.push_back(Optimization(pass));
  summary["loops"]["refinement_passes"] = passes;
  summary["loops"]["candidates"] = candidates;

  summary["time_ms"] = {{"scan_total", Stage(record, TotalMs)},
                        {"project", Stage(record, [](const ScanResult& scan) { return scan.project_ms; })},
                        {"match", Stage(record, [](const ScanResult& scan) { return scan.match_ms; })},
                        {"window", Stage(record, [](const ScanResult& scan) { return scan.window_ms; })},
                        {"insert", Stage(record, [](const ScanResult& scan) { return scan.insert_ms; })},
                        {"loop_search", record.finish.loop_ms},
                        {"map_refinement", record.finish.refine_ms},
                        {"optimization", record.finish.optimize_ms},
                        {"run", 1000.0 * record.wall_seconds}};
  summary["peak_memory_mib"] = PeakMemoryMib();
  if (record.errors) {
    summary["errors"] = {{"unmatched_poses", record.errors->unmatched_poses},
                         {"path_length_m", record.errors->trajectory.path_length()},
                         {"trajectory", Errors(record.errors->trajectory)},
                         {"odometry", Errors(record.errors->odometry)}};
  }
  return summary.dump(2) + "\n";
}

std::string SummaryText(const RunRecord& record) {
  const std::vector<double> totals = OverPosedScans(record, TotalMs);
  const size_t num_rejected = CountStatus(record, ScanStatus::kPredicted);
  const double share =
      totals.empty() ? 0.0 : 100.0 * static_cast<double>(num_rejected) / static_cast<double>(totals.size());
  char text[1024];
  std::snprintf(text, sizeof(text),
                "%zu scans: %zu matched (%zu of them too spoilt for the map), %zu rejected (%.1f %%), %zu skipped\n"
                "%zu submaps, %zu of %zu loops accepted\n"
                "time per scan: median %.2f ms, p95 %.2f ms; loops and optimisation %.2f s; whole run %.2f s\n"
                "peak memory %.0f MiB\n",
                record.scans.size(), CountStatus(record, ScanStatus::kMatched), CountSpoilt(record), num_rejected,
                share, CountStatus(record, ScanStatus::kSkipped), record.num_submaps, CountAcceptedLoops(record),
                record.finish.loops.size(), Percentile(totals, 0.5), Percentile(totals, 0.95),
                (record.finish.loop_ms + record.finish.optimize_ms + record.finish.refine_ms) / 1000.0,
                record.wall_seconds, PeakMemoryMib());
  std::string result = text;
  if (record.errors) {
    const auto line = [&](const char* name, const TrajectoryMetrics& metrics) {
      std::snprintf(text, sizeof(text), "%s: ATE RMSE %.4f m, max %.3f m, end %.3f m (SE(2)-aligned)\n", name,
                    metrics.ate_rmse, metrics.ate_max, metrics.end_error);
      result += text;
    };
    line("trajectory", record.errors->trajectory.metrics);
    line("odometry  ", record.errors->odometry.metrics);
  }
  return result;
}

}  // namespace arborslam
