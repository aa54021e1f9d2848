#include "apps/offline/summary.h"

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/common/error_json.h"
#include "apps/common/version.h"
#include "apps/offline/run_figures.h"

namespace arborslam {
namespace {

using Json = nlohmann::ordered_json;

Json Stage(const std::vector<double>& times_ms) {
  return {
      {"median", Percentile(times_ms, 0.5)}, {"p95", Percentile(times_ms, 0.95)}, {"max", Percentile(times_ms, 1.0)}};
}

Json Errors(const TrajectoryEvaluation& evaluation) { return ErrorsJson(evaluation.alignment, evaluation.metrics); }

Json Errors(const LoopErrors& loops) {
  return {{"tried", loops.num_tried},
          {"accepted", loops.num_accepted},
          {"false", loops.num_false},
          {"precision", loops.Precision()},
          {"recall", loops.Recall()},
          {"translation_rms_m", loops.translation_rms},
          {"translation_max_m", loops.translation_max}};
}

Json Optimization(const PoseGraphSummary& summary) {
  return {{"initial_cost", summary.initial_cost},
          {"final_cost", summary.final_cost},
          {"iterations", summary.iterations},
          {"loops_dropped", summary.dropped_loops.size()}};
}

Json Optimizations(const std::vector<PoseGraphSummary>& summaries) {
  Json optimizations = Json::array();
  for (const PoseGraphSummary& summary : summaries) optimizations.push_back(Optimization(summary));
  return optimizations;
}

Json Merge(const JoinRecord& join) {
  const PlaceVotes& votes = join.votes;
  const bool is_placed = votes.reason.empty();
  Json merge{{"session", join.session},
             {"placed", is_placed},
             {"reason", votes.reason},
             {"votes",
              {{"asked", votes.num_asked},
               {"recognized", votes.num_recognized},
               {"agreeing", votes.agreeing.size()},
               {"rivals", votes.num_rivals}}},
             {"place_ms", join.place_ms}};
  if (!is_placed) return merge;
  const MergeSolution& solution = join.solution;
  merge["pose"] = {{"x_m", votes.T_a_b.x()}, {"y_m", votes.T_a_b.y()}, {"theta_rad", votes.T_a_b.theta()}};
  merge["loops_across"] = {{"tried", solution.num_cross_tried}, {"accepted", solution.num_cross_accepted}};
  merge["optimization"] = Optimization(solution.loop_optimization);
  merge["refinement_passes"] = Optimizations(solution.refinements);
  merge["solution_ms"] = solution.loop_ms + solution.optimize_ms + solution.refine_ms;
  return merge;
}

}  // namespace

std::string SummaryJson(const RunRecord& record) {
  Json summary;
  summary["program"] = std::string("arborslam_offline ") + kVersion;
  summary["input"] = record.input;
  summary["threads"] = record.num_threads;
  summary["odometry_only"] = record.odometry_only;
  summary["interrupted"] = record.is_interrupted;
  summary["verdict"] = {{"state", ToString(record.verdict.state)}, {"reasons", record.verdict.reasons}};
  summary["notices"] = record.notices;

  const RunCounts counts = CountRun(record);
  summary["scans"] = {{"read", record.scans.size()},
                      {"matched", counts.matched},
                      {"rejected", counts.rejected},
                      {"skipped", counts.skipped},
                      {"spoilt", counts.spoilt},
                      {"keyframes", counts.keyframes},
                      {"searched_wide", counts.searched_wide},
                      {"degenerate", counts.degenerate}};
  const std::vector<size_t> indices = PosedIndices(record);
  Json segments = Json::array();
  for (const MapSegment& segment : record.finish.segments) {
    segments.push_back({{"first_index", indices[segment.first_scan]},
                        {"last_index", indices[segment.last_scan]},
                        {"joined", segment.is_joined}});
  }
  summary["segments"] = segments;
  Json unused = Json::array();
  size_t num_posed = 0;
  for (size_t i = 0; i < record.scans.size(); ++i) {
    const ScanResult& scan = record.scans[i];
    const char* pose = "none";
    if (scan.status != ScanStatus::kSkipped && num_posed < record.finish.pose_sources.size()) {
      pose = ToString(record.finish.pose_sources[num_posed++]);
    }
    if (scan.status == ScanStatus::kMatched) continue;
    unused.push_back({{"index", i},
                      {"stamp_s", scan.stamp},
                      {"status", ToString(scan.status)},
                      {"reason", scan.reason},
                      {"pose", pose},
                      {"points", scan.match.num_points},
                      {"mhd_m", scan.match.score},
                      {"inlier_ratio", scan.match.inlier_ratio}});
  }
  summary["unused_scans"] = unused;
  Json stretches = Json::array();
  for (const DegenerateStretch& stretch : DegenerateStretches(record)) {
    stretches.push_back({{"first_index", stretch.first}, {"last_index", stretch.last}, {"length_m", stretch.length_m}});
  }
  summary["degenerate_stretches"] = stretches;

  summary["submaps"] = record.num_submaps;
  std::map<std::string, int> refused;
  Json candidates = Json::array();
  for (const LoopCandidate& loop : record.finish.loops) {
    if (!loop.accepted) ++refused[loop.reason];
    candidates.push_back({{"keyframe", loop.keyframe.value},
                          {"submap", loop.submap.value},
                          {"accepted", loop.accepted},
                          {"reason", loop.reason},
                          {"search_translation_m", loop.search_translation},
                          {"search_rotation_rad", loop.search_rotation},
                          {"mhd_m", loop.match.score},
                          {"inlier_ratio", loop.match.inlier_ratio},
                          {"second_best_mhd_m", loop.match.second_score},
                          {"T_submap_base", {loop.match.pose.x(), loop.match.pose.y(), loop.match.pose.theta()}}});
  }
  summary["loops"] = {{"searches", record.finish.num_loop_searches},
                      {"tried", record.finish.loops.size()},
                      {"accepted", counts.loops_accepted},
                      {"refused", refused},
                      {"optimization", Optimization(record.finish.loop_optimization)}};
  summary["loops"]["refinement_passes"] = Optimizations(record.finish.refinements);
  summary["loops"]["candidates"] = candidates;

  if (record.join) summary["merge"] = Merge(*record.join);

  if (record.cloud) {
    summary["cloud"] = {{"sweeps", record.cloud->num_sweeps},
                        {"points", record.cloud->num_points},
                        {"voxel_size_m", record.cloud->voxel_size}};
  }

  Json times{{"scan_total", Stage(OverPosedScans(record, &TotalMs))}};
  for (const StageField& field : StageFields()) times[field.key] = Stage(OverPosedScans(record, field.time_ms));
  times["loop_search"] = record.finish.loop_ms;
  times["map_refinement"] = record.finish.refine_ms;
  times["optimization"] = record.finish.optimize_ms;
  times["terrain"] = record.finish.terrain_ms;
  times["second_pass"] = record.maps_ms;
  times["run"] = 1000.0 * record.wall_seconds;
  summary["time_ms"] = times;
  summary["peak_memory_mib"] = PeakMemoryMib();
  if (record.errors) {
    summary["errors"] = {{"unmatched_poses", record.errors->unmatched_poses},
                         {"path_length_m", record.errors->trajectory.path_length()},
                         {"trajectory", Errors(record.errors->trajectory)},
                         {"odometry", Errors(record.errors->odometry)}};
    if (record.errors->loops) summary["errors"]["loops"] = Errors(*record.errors->loops);
  }
  // Names of files may be of any bytes, JSON may not.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string SummaryText(const RunRecord& record) {
  const std::vector<double> totals = OverPosedScans(record, &TotalMs);
  const RunCounts counts = CountRun(record);
  const double share =
      totals.empty() ? 0.0 : 100.0 * static_cast<double>(counts.rejected) / static_cast<double>(totals.size());
  char text[1024];
  std::snprintf(
      text, sizeof(text),
      "%zu scans: %zu matched (%zu of them too spoilt for the map), %zu rejected (%.1f %%), %zu skipped\n"
      "%zu submaps, %zu of %zu loops accepted\n"
      "time per scan: median %.2f ms, p95 %.2f ms; loops and optimisation %.2f s; maps %.2f s; whole run %.2f "
      "s\n"
      "peak memory %.0f MiB\n",
      record.scans.size(), counts.matched, counts.spoilt, counts.rejected, share, counts.skipped, record.num_submaps,
      counts.loops_accepted, record.finish.loops.size(), Percentile(totals, 0.5), Percentile(totals, 0.95),
      (record.finish.loop_ms + record.finish.optimize_ms + record.finish.refine_ms) / 1000.0, record.maps_ms / 1000.0,
      record.wall_seconds, PeakMemoryMib());
  std::string result = text;
  if (record.join) result += record.input + ": " + TextOf(*record.join) + "\n";
  if (record.errors) {
    const auto line = [&](const char* name, const TrajectoryMetrics& metrics) {
      std::snprintf(text, sizeof(text), "%s: ATE RMSE %.4f m, max %.3f m, end %.3f m (SE(2)-aligned)\n", name,
                    metrics.ate_rmse, metrics.ate_max, metrics.end_error);
      result += text;
    };
    line("trajectory", record.errors->trajectory.metrics);
    line("odometry  ", record.errors->odometry.metrics);
    if (record.errors->loops && record.errors->loops->num_tried > 0) {
      const LoopErrors& loops = *record.errors->loops;
      std::snprintf(text, sizeof(text), "loops     : %zu of %zu false, recall %.3f, off by %.3f m (RMS)\n",
                    loops.num_false, loops.num_accepted, loops.Recall(), loops.translation_rms);
      result += text;
    }
  }
  return result;
}

}  // namespace arborslam
