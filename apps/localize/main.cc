// arborslam_localize: where a recording was made in the map of a session.

#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "apps/common/error_json.h"
#include "apps/common/output_folder.h"
#include "apps/common/program.h"
#include "apps/common/progress_bar.h"
#include "apps/common/version.h"
#include "apps/offline/offline_options.h"
#include "backend/localization/localizer.h"
#include "backend/store/session_reader.h"
#include "core/config/config_schema.h"
#include "core/error.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/atomic_file.h"
#include "core/io/scan_source.h"
#include "core/io/trajectory_io.h"
#include "frontend/mounting/levelled_source.h"

DEFINE_string(session, "", "session file that holds the map");
DEFINE_string(input, "", "recording to localise");
DEFINE_string(output, "", "folder for the results");
DEFINE_string(initial_pose, "", "x,y,theta of the first scan");
DEFINE_string(config, "", "YAML file with options");
DEFINE_string(ground_truth, "", "reference trajectory to report errors against");
DEFINE_int32(max_scans, 0, "stop after this many scans, 0: never");
DEFINE_bool(quiet, false, "print errors only");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_localize --session FILE.db --input PATH --output DIR [flags]

Finds where each scan of a recording was taken in the map of a session, which is not changed. No initial pose is needed:
the robot counts as located once several scans agree. When it is lost, that is reported and it is sought anew.

  --session FILE.db      map, from arborslam_offline
  --input PATH           recording, of the kind that the session was made from
  --output DIR           created if it does not exist
  --initial_pose X,Y,THETA
                         [m, m, rad] of the first scan in the map's frame, to about a metre, if it is known
  --config FILE.yaml     options over the session's own; besides its sections there is 'localization'
  --set SECTION.KEY=VALUE ...
                         one option each, after the file's
  --ground_truth FILE    TUM file or .npz with gnss_rotated_c; reported against, never used
  --max_scans N          stop after N scans
  --quiet                print errors only
  --help, --version

Writes trajectory.tum (pose of every located scan in the map's frame; a pose's stamp is the middle of its sweep) and
summary.json (counts, fixes, losses, jumps, the state of every scan, errors).
)";

void CheckFlags() {
  for (const auto& [name, value, kind] :
       {std::make_tuple("session", &FLAGS_session, "FILE.db"), std::make_tuple("input", &FLAGS_input, "PATH"),
        std::make_tuple("output", &FLAGS_output, "DIR")}) {
    if (value->empty()) throw UsageError(std::string("--") + name + " " + kind + " is missing; see --help");
  }
  if (FLAGS_max_scans < 0) {
    throw UsageError("--max_scans is " + std::to_string(FLAGS_max_scans) + " but must be 0 or more");
  }
}

// The pose of --initial_pose, if it is given.
std::optional<SE2> InitialPose() {
  if (FLAGS_initial_pose.empty()) return std::nullopt;
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;
  int used = 0;
  const int count = std::sscanf(FLAGS_initial_pose.c_str(), "%lf,%lf,%lf%n", &x, &y, &theta, &used);
  if (count != 3 || static_cast<size_t>(used) != FLAGS_initial_pose.size() ||
      !Eigen::Vector3d(x, y, theta).allFinite()) {
    throw UsageError("--initial_pose is '" + FLAGS_initial_pose +
                     "' but must be three numbers X,Y,THETA [m, m, rad] with commas between");
  }
  return SE2(x, y, theta);
}

// What summary.json and the last lines tell.
struct Figures {
  size_t num_scans = 0;
  size_t num_located = 0;
  size_t num_measured = 0;
  size_t num_losses = 0;
  size_t num_jumps = 0;
  std::vector<size_t> fixes;  // Scans, counted from 0.
  std::optional<TrajectoryMetrics> errors;
};

Figures FiguresOf(const std::vector<LocalizationResult>& results) {
  Figures figures;
  figures.num_scans = results.size();
  LocalizationState last = LocalizationState::kNotYetLocated;
  for (size_t i = 0; i < results.size(); ++i) {
    const LocalizationResult& result = results[i];
    figures.num_located += result.state == LocalizationState::kLocated ? 1 : 0;
    figures.num_measured += result.is_measured ? 1 : 0;
    figures.num_losses += result.state == LocalizationState::kLost && last != LocalizationState::kLost ? 1 : 0;
    figures.num_jumps += result.jump > 0.0 ? 1 : 0;
    if (result.is_fix) figures.fixes.push_back(i);
    last = result.state;
  }
  return figures;
}

std::string SummaryJson(const std::vector<LocalizationResult>& results, const Figures& figures) {
  using Json = nlohmann::ordered_json;
  Json summary;
  summary["program"] = std::string("arborslam_localize ") + kVersion;
  summary["session"] = FLAGS_session;
  summary["input"] = FLAGS_input;
  summary["scans"] = {
      {"read", figures.num_scans}, {"located", figures.num_located}, {"measured", figures.num_measured}};
  summary["fixes"] = figures.fixes;
  summary["losses"] = figures.num_losses;
  Json jumps = Json::array();
  Json states = Json::array();
  for (size_t i = 0; i < results.size(); ++i) {
    const LocalizationResult& result = results[i];
    if (result.jump > 0.0) jumps.push_back({{"index", i}, {"metres", result.jump}});
    states.push_back({{"index", i},
                      {"stamp_s", result.odometry.stamp},
                      {"state", ToString(result.state)},
                      {"measured", result.is_measured},
                      {"reason", result.reason},
                      {"mhd_m", result.match.score},
                      {"inlier_ratio", result.match.inlier_ratio}});
  }
  summary["jumps"] = jumps;
  if (figures.errors) summary["errors"] = ErrorsJson(AlignmentKind::kSe2, *figures.errors);
  summary["states"] = states;
  // Names of files may be of any bytes, JSON may not.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string SummaryText(const Figures& figures) {
  char text[512];
  std::snprintf(text, sizeof(text),
                "%zu scans: %zu located (%.1f %%), %zu of them measured in the map\n"
                "%zu fixes, lost %zu times, %zu jumps\n",
                figures.num_scans, figures.num_located,
                100.0 * static_cast<double>(figures.num_located) / static_cast<double>(figures.num_scans),
                figures.num_measured, figures.fixes.size(), figures.num_losses, figures.num_jumps);
  std::string result = text;
  if (figures.fixes.empty()) {
    result += "not located: the recording was not found in the map\n";
  } else {
    result += "first fix with scan " + std::to_string(figures.fixes.front() + 1) + "\n";
  }
  if (figures.errors) {
    std::snprintf(text, sizeof(text), "trajectory: ATE RMSE %.4f m, max %.3f m (SE(2)-aligned)\n",
                  figures.errors->ate_rmse, figures.errors->ate_max);
    result += text;
  }
  return result;
}

std::vector<LocalizationResult> Localize(ScanSource* source, bool map_is_spatial, Localizer* localizer) {
  std::optional<size_t> total = source->NumScans();
  if (total && FLAGS_max_scans > 0) total = std::min(*total, static_cast<size_t>(FLAGS_max_scans));
  ProgressBar progress(std::cerr, total, StderrIsTerminal() && !FLAGS_quiet);
  std::vector<LocalizationResult> results;
  while (FLAGS_max_scans == 0 || results.size() < static_cast<size_t>(FLAGS_max_scans)) {
    const std::optional<Scan> scan = source->Next();
    if (!scan) break;
    if (std::holds_alternative<LidarSweep>(*scan) != map_is_spatial) {
      throw UserError(FLAGS_input,
                      map_is_spatial ? "holds planar scans, but the session was made from sweeps in space"
                                     : "holds sweeps in space, but the session was made from planar scans",
                      "give a session of the same kind of lidar");
    }
    results.push_back(std::visit([localizer](const auto& any) { return localizer->AddScan(any); }, *scan));
    progress.Update(results.size());
  }
  return results;
}

Trajectory3 LocatedTrajectory(const std::vector<LocalizationResult>& results) {
  Trajectory3 trajectory;
  for (const LocalizationResult& result : results) {
    if (result.state != LocalizationState::kLocated || result.odometry.status == ScanStatus::kSkipped) continue;
    trajectory.poses.push_back(Lifted({result.odometry.stamp, result.T_map_base}, result.odometry.tilt));
  }
  return trajectory;
}

int Run(const MultiFlags& multi_flags) {
  CheckFlags();
  const std::optional<SE2> initial_pose = InitialPose();
  OfflineOptions options;
  LocalizerOptions localization;
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) { schema.AddSection(name, &section); });
  schema.AddSection("localization", &localization);
  schema.LoadYaml(ReadSessionSummary(FLAGS_session).config, FLAGS_session + ", options");
  const SlamOptions session_options = options.slam;
  if (!FLAGS_config.empty()) schema.LoadYamlFile(FLAGS_config);
  for (const std::string& assignment : multi_flags.at("set")) schema.ApplyOverride(assignment);
  schema.ValidateAll();
  const std::shared_ptr<ValueStore> store = MakeStore(options.memory);
  const SessionContents session = Completed(ReadSession(FLAGS_session, store), session_options, FLAGS_session);
  if (session.submaps.empty()) {
    throw UserError(FLAGS_session, "holds no map", "give the session of a run that has scans");
  }
  std::optional<Trajectory3> reference;
  if (!FLAGS_ground_truth.empty()) reference = ReadTrajectory(FLAGS_ground_truth);
  const std::unique_ptr<ScanSource> source = OpenLevelledSource(FLAGS_input, options.input);
  const std::filesystem::path folder = PrepareOutputFolder(FLAGS_output, {"trajectory.tum", "summary.json"},
                                                           {FLAGS_session, FLAGS_input, FLAGS_ground_truth});
  if (!FLAGS_quiet) {
    for (const std::string& notice : source->Notices()) std::cerr << "note: " << notice << "\n";
  }

  const bool map_is_spatial = IsSpatial(session);
  Localizer localizer(options.slam, localization, session.graph, session.keyframes, session.submaps, initial_pose,
                      store);
  const std::vector<LocalizationResult> results = Localize(source.get(), map_is_spatial, &localizer);
  if (results.empty()) throw UserError(FLAGS_input, "holds no scans", "nothing was written");
  Figures figures = FiguresOf(results);
  const Trajectory3 trajectory = LocatedTrajectory(results);
  if (reference && !trajectory.poses.empty()) {
    const AssociationResult pairs =
        Associate(trajectory, *reference, AssociationOptions{}, FLAGS_input + " and " + FLAGS_ground_truth);
    figures.errors = EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2).metrics;
  }
  WriteTum((folder / "trajectory.tum").string(), trajectory);
  WriteFileAtomically((folder / "summary.json").string(), SummaryJson(results, figures));
  if (!FLAGS_quiet) std::cout << SummaryText(figures) << "results in " << folder.string() << "\n" << std::flush;
  return kExitSuccess;
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram({"arborslam_localize", arborslam::kUsage, __FILE__, {"set"}}, argc, argv,
                               &arborslam::Run);
}
