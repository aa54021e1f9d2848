// arborslam_offline: a recorded run in, an optimised trajectory and a map out.

#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "apps/common/output_folder.h"
#include "apps/common/program.h"
#include "apps/common/progress_bar.h"
#include "apps/offline/cloud.h"
#include "apps/offline/footprints.h"
#include "apps/offline/graph_export.h"
#include "apps/offline/graph_run.h"
#include "apps/offline/html_report.h"
#include "apps/offline/loop_errors.h"
#include "apps/offline/map_picture.h"
#include "apps/offline/offline_options.h"
#include "apps/offline/second_pass.h"
#include "apps/offline/summary.h"
#include "backend/slam.h"
#include "backend/store/fingerprint.h"
#include "backend/store/session_contents.h"
#include "backend/store/session_reader.h"
#include "backend/store/session_writer.h"
#include "core/config/config_schema.h"
#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/g2o.h"
#include "core/io/map_io.h"
#include "core/io/ply.h"
#include "core/io/png.h"
#include "core/io/scan_source.h"
#include "core/io/text_reader.h"
#include "core/io/trajectory_io.h"
#include "core/map/height_colours.h"
#include "core/stopwatch.h"

DEFINE_string(input, "", "recording to process");
DEFINE_string(output, "", "folder for the results");
DEFINE_string(session, "", "session to go on with");
DEFINE_string(config, "", "YAML file with options");
DEFINE_string(ground_truth, "", "reference trajectory to report errors against");
DEFINE_int32(threads, 0, "threads for loop closure and optimisation, 0: all cores");
DEFINE_bool(odometry_only, false, "close no loops");
DEFINE_int32(max_scans, 0, "stop after this many scans, 0: never");
DEFINE_bool(quiet, false, "print errors only");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_offline --input PATH --output DIR [flags]

Smooths a recorded run: matches every scan, closes loops, and writes the trajectory and the map into DIR. The same input
and options give the same results, bit by bit, for any number of threads.

  --input PATH           recording: a folder of 3D sweeps (KITTI .bin, .pcd or .ply, with timestamps.txt or times.txt),
                         a .npz file of planar scans: scan0 (N x B ranges [m]) and time (N stamps [s]), or a CARMEN log
                         (.clf, .carmen, .log: FLASER, ROBOTLASER1, ODOM), whose odometry is used; or a pose graph, .g2o
                         (VERTEX_SE2, EDGE_SE2, FIX), which is smoothed as it is
  --output DIR           created if it does not exist
  --session FILE.db      goes on with an interrupted run: --input is the recording that it was made from; what the
                         session holds already is not tracked again, and the results are those of a run in one piece
                         (another recording of the place: map it by itself, then arborslam_session merge)
  --config FILE.yaml     options; config/default.yaml lists them all; with --session, those of the session come first
  --set SECTION.KEY=VALUE ...
                         one option each, after the file's
  --ground_truth FILE    TUM file or .npz with gnss_rotated_c; for a pose graph also lines of id x y theta, or a .g2o;
                         reported against, never used
  --threads N            for loop closure and optimisation (default, and at most: all cores)
  --odometry_only        close no loops: trajectory.tum is what the sliding window left
  --max_scans N          stop after N scans
  --quiet                print errors only
  --help, --version

Writes trajectory.tum (optimised pose of every scan used), odometry.tum (the causal estimate, as known when the scan came),
map.pgm + map.yaml (ROS map_server), map.png, cloud.ply (3D map, from 3D sweeps), graph.g2o, summary.json (counts, rejected scans with reasons, loops, times,
memory, errors), report.html (all of this for the browser, in one file) and effective_config.yaml; and session.db, the
run as it goes, from which --session and arborslam_session start, also when this program was killed. A pose's stamp is the
middle of its sweep. Of a pose graph: trajectory.tum (every vertex, its id as the stamp), graph.g2o, graph.png,
summary.json, report.html and effective_config.yaml. Ctrl-C ends the reading early and keeps what there is (exit code
130), but makes no 3D map; a second one ends the program at once.
)";

// After an interruption the exit code is this and the signal's number, as shells have it.
constexpr int kExitSignalled = 128;

constexpr char kCloudFile[] = "cloud.ply";
constexpr char kSessionFile[] = "session.db";
constexpr std::array<const char*, 12> kResultFiles = {"trajectory.tum",
                                                      "odometry.tum",
                                                      "map.yaml",
                                                      "map.pgm",
                                                      "map.png",
                                                      kCloudFile,
                                                      "graph.g2o",
                                                      "graph.png",
                                                      "summary.json",
                                                      "report.html",
                                                      "effective_config.yaml",
                                                      kSessionFile};

// The signal that asks for an early end, or 0. A handler can reach nothing else.
volatile std::sig_atomic_t g_signal = 0;

void OnSignal(int signal) {
  g_signal = signal;
  std::signal(signal, SIG_DFL);
}

void CheckFlags() {
  if (FLAGS_input.empty()) throw UsageError("--input PATH is missing; see --help");
  if (FLAGS_output.empty()) throw UsageError("--output DIR is missing; see --help");
  if (FLAGS_threads < 0 || FLAGS_threads > 1024) {
    throw UsageError("--threads is " + std::to_string(FLAGS_threads) + " but must lie in [0, 1024]");
  }
  if (FLAGS_max_scans < 0) {
    throw UsageError("--max_scans is " + std::to_string(FLAGS_max_scans) + " but must be 0 or more");
  }
}

// More threads than the machine has are of no use, and Ceres complains about them.
int NumThreads() {
  const int available = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return FLAGS_threads > 0 ? std::min(FLAGS_threads, available) : available;
}

std::filesystem::path PrepareOutput() {
  return PrepareOutputFolder(FLAGS_output, {kResultFiles.begin(), kResultFiles.end()},
                             {FLAGS_input, FLAGS_ground_truth});
}

StampedPose3 CausalPose(const ScanResult& result) { return Lifted({result.stamp, result.T_odom_base}, result.tilt); }

// Passes over the scans that the session `read` holds, which must be those of the recording; fills the record's scans
// and the causal trajectory with what it says of them. True if the scans are in space.
bool SkipTracked(ScanSource* source, const std::vector<SessionContents::ReadScan>& read, RunRecord* record,
                 Trajectory3* odometry) {
  bool has_sweeps = false;
  for (size_t i = 0; i < read.size(); ++i) {
    const std::optional<Scan> scan = source->Next();
    if (!scan) {
      throw UserError(FLAGS_input,
                      "holds " + std::to_string(i) + " scans, but the session " + FLAGS_session + " was made from " +
                          std::to_string(read.size()),
                      "give the recording that the session was made from");
    }
    has_sweeps = std::holds_alternative<LidarSweep>(*scan);
    const double stamp = has_sweeps ? std::get<LidarSweep>(*scan).Middle() : std::get<LaserScan>(*scan).stamp;
    const bool is_known = read[i].fingerprint != 0;
    if (stamp != read[i].result.stamp || (is_known && FingerprintOf(*scan) != read[i].fingerprint)) {
      throw UserError(
          FLAGS_input,
          "scan " + std::to_string(i + 1) + " is not the one that the session " + FLAGS_session + " was made from",
          "give the recording that the session was made from; map another one by itself and merge the two sessions");
    }
    record->scans.push_back(read[i].result);
    if (read[i].result.status != ScanStatus::kSkipped) odometry->poses.push_back(CausalPose(read[i].result));
  }
  return has_sweeps;
}

// Keeps what the run has come to, for --session; without keyframes that is nothing.
void KeepSession(const Slam& slam, SessionWriter* session) {
  if (slam.keyframes().empty()) {
    session->Discard();
  } else {
    session->Commit(slam);
  }
}

std::optional<Scan> NextScan(ScanSource* source, const Slam& slam, SessionWriter* session) {
  try {
    return source->Next();
  } catch (const UserError&) {
    KeepSession(slam, session);
    throw;
  }
}

// Feeds the recording to `slam` and the session; fills the record's scans and the causal trajectory. True if the scans
// are in space.
bool Track(ScanSource* source, Slam* slam, SessionWriter* session, RunRecord* record, Trajectory3* odometry) {
  std::optional<size_t> total = source->NumScans();
  if (total && FLAGS_max_scans > 0) total = std::min(*total, static_cast<size_t>(FLAGS_max_scans));
  ProgressBar progress(std::cerr, total, StderrIsTerminal() && !FLAGS_quiet);
  bool has_sweeps = false;
  while (g_signal == 0 && (FLAGS_max_scans == 0 || record->scans.size() < static_cast<size_t>(FLAGS_max_scans))) {
    const std::optional<Scan> scan = NextScan(source, *slam, session);
    if (!scan) break;
    has_sweeps = std::holds_alternative<LidarSweep>(*scan);
    record->scans.push_back(std::visit([slam](const auto& any) { return slam->AddScan(any); }, *scan));
    const ScanResult& result = record->scans.back();
    session->Add(FingerprintOf(*scan), result, *slam);
    if (result.status != ScanStatus::kSkipped) odometry->poses.push_back(CausalPose(result));
    progress.Update(record->scans.size());
  }
  record->is_interrupted = g_signal != 0;
  KeepSession(*slam, session);
  return has_sweeps;
}

// Corrects the stamps by what the run told of the sweeps' duration, and says what that is.
void TakeDuration(const SweepDurationResult& duration, RunRecord* record, Trajectory3* odometry) {
  for (ScanResult& scan : record->scans) scan.stamp += duration.stamp_shift;
  for (StampedPose3& pose : odometry->poses) pose.stamp += duration.stamp_shift;
  const std::string seconds = ShortestText(std::round(duration.seconds * 1e3) / 1e3) + " s";
  record->notices.push_back(duration.is_found
                                ? "Sweeps are taken to last " + seconds + ": found from the motion within " +
                                      std::to_string(duration.estimate.num_sweeps) + " sweeps."
                                : "The motion does not tell how long a sweep lasts; it stays at " + seconds +
                                      " (option input.sweep_duration).");
  if (!FLAGS_quiet) std::cerr << "note: " << record->notices.back() << "\n";
}

void RequireKeyframes(const Slam& slam, const RunRecord& record) {
  if (!slam.keyframes().empty()) return;
  if (record.scans.empty()) {
    throw UserError(FLAGS_input, record.is_interrupted ? "interrupted before the first scan" : "holds no scans",
                    "nothing was written");
  }
  throw UserError(FLAGS_input, "none of its " + std::to_string(record.scans.size()) + " scans has enough returns",
                  "check the recording and the range limits of section 'projection'");
}

// Fills the record's errors. Returns what is wrong with the reference, or "": a run is not to be lost for it.
std::string EvaluateRun(const Slam& slam, const Trajectory3& odometry, const Trajectory3& reference,
                        RunRecord* record) {
  const auto associate = [&reference](const Trajectory3& estimate) {
    return Associate(estimate, reference, AssociationOptions{}, FLAGS_input + " and " + FLAGS_ground_truth);
  };
  const auto evaluate = [](const AssociationResult& pairs) {
    return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2);
  };
  try {
    RunErrors errors;
    const AssociationResult trajectory_pairs = associate(slam.OptimizedTrajectory3());
    const AssociationResult odometry_pairs = associate(odometry);
    errors.trajectory = evaluate(trajectory_pairs);
    errors.odometry = evaluate(odometry_pairs);
    errors.unmatched_poses = odometry_pairs.unmatched_estimate;
    if (trajectory_pairs.has_headings) {
      errors.loops = EvaluateLoops(record->finish.loops, slam.submaps(), slam.scans(), trajectory_pairs.pairs);
    }
    record->errors = std::move(errors);
    return "";
  } catch (const UserError& error) {
    record->notices.push_back(std::string("No errors against the ground truth: ") + error.what() + ".");
    return error.what();
  }
}

// What the score of a scan is held to.
std::vector<ScoreGate> ScoreGates(const SlamOptions& options) {
  return {{options.tracker.wide_score, "searched wide (tracker.wide_score)"},
          {options.tracker.max_insert_score, "kept out of the maps (tracker.max_insert_score)"},
          {options.matcher.max_score, "rejected (matcher.max_score)"}};
}

// What comes of the run besides trajectories.
struct Maps {
  GridImage plane;
  std::vector<Eigen::Vector3f> cloud;  // Empty if there is none.
};

// Reads a recording of sweeps again for the maps that need all of their points. What it cannot make is left as it is,
// and why goes to the record's notices: a run is not to be lost for it.
void RefineMaps(const Slam& slam, const OfflineOptions& options, RunRecord* record, Maps* maps) {
  std::optional<Cloud> cloud;
  if (options.cloud.enabled) cloud.emplace(options.cloud, options.slam.reduction.deskew);
  std::optional<Footprints> footprints;
  if (options.map.resolution > 0.0 && options.map.resolution < options.slam.grid.cell_size) {
    footprints.emplace(maps->plane, options.map, options.slam);
  }
  if (!cloud && !footprints) return;
  Stopwatch stopwatch;
  std::string problem;
  try {
    ProgressBar progress(std::cerr, record->scans.size(), StderrIsTerminal() && !FLAGS_quiet);
    const bool is_whole = g_signal == 0 && VisitMatchedSweeps(
                                               OpenScanSource(FLAGS_input, options.input).get(), record->scans,
                                               record->finish.sweep_duration, slam.OptimizedTrajectory3(),
                                               [&](const PosedSweep& sweep) {
                                                 if (cloud) cloud->Add(sweep);
                                                 if (footprints) footprints->Add(sweep);
                                               },
                                               [&progress](size_t num_read) {
                                                 progress.Update(num_read);
                                                 return g_signal == 0;
                                               });
    if (is_whole) {
      if (footprints) maps->plane = footprints->Image();
      if (cloud) maps->cloud = cloud->Points();
    } else {
      problem = "interrupted";
      record->maps_are_whole = false;
    }
  } catch (const UserError& error) {
    problem = error.what();
  }
  record->maps_ms = stopwatch.Lap();
  if (!maps->cloud.empty()) {
    record->cloud = CloudRecord{cloud->num_sweeps(), maps->cloud.size(), cloud->voxel_size()};
  } else if (cloud && problem.empty()) {
    problem = "no place was met by as many sweeps as cloud.min_sweeps asks for";
  }
  if (problem.empty()) return;
  record->notices.push_back((cloud ? "No 3D map" : "The map is coarser than map.resolution") + (": " + problem) + ".");
  if (!FLAGS_quiet) std::cerr << "note: " << record->notices.back() << "\n";
}

void WriteResults(const std::filesystem::path& folder, const SlamOptions& options, const Slam& slam,
                  const Trajectory3& odometry, const Maps& maps, const RunRecord& record,
                  const std::string& effective_config) {
  const Trajectory3 trajectory = slam.OptimizedTrajectory3();
  WriteTum((folder / "trajectory.tum").string(), trajectory);
  WriteTum((folder / "odometry.tum").string(), odometry);
  WriteMapServer((folder / "map.yaml").string(), maps.plane);
  WritePng((folder / "map.png").string(), DrawMap(maps.plane, {slam.OptimizedTrajectory()}));
  if (maps.cloud.empty()) {
    // An earlier run's would be taken for this one's.
    std::error_code error;
    std::filesystem::remove(folder / kCloudFile, error);
  } else {
    WritePly((folder / kCloudFile).string(), maps.cloud, ColourByHeight(maps.cloud));
  }
  WriteG2o((folder / "graph.g2o").string(), ToG2o(slam.graph()));
  WriteFileAtomically((folder / "effective_config.yaml").string(), effective_config);
  WriteFileAtomically((folder / "summary.json").string(), SummaryJson(record));
  const ReportInput report{record,     slam.submaps(), effective_config,   &maps.plane,
                           trajectory, odometry,       ScoreGates(options)};
  WriteFileAtomically((folder / "report.html").string(), HtmlReport(report));
}

// The options that scans are tracked by: those of all sections but those that only the end of a run reads.
std::string TrackingConfig(OfflineOptions options) {
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) {
    for (const char* last : {"loop", "graph", "map_refinement", "map", "cloud"}) {
      if (name == last) return;
    }
    schema.AddSection(name, &section);
  });
  return schema.ToYaml();
}

// The session of this run in `folder`: a new one, or, with --session, that one or a copy of it, which holds `tracked`.
std::unique_ptr<SessionWriter> OpenSession(const std::filesystem::path& folder, const std::string& config,
                                           const SessionContents& tracked) {
  const std::string path = (folder / kSessionFile).string();
  if (FLAGS_session.empty()) return SessionWriter::Create(path, config, FLAGS_input);
  std::error_code error;
  if (!std::filesystem::equivalent(FLAGS_session, path, error)) CopySession(FLAGS_session, path);
  return SessionWriter::Continue(path, tracked);
}

int Run(const MultiFlags& multi_flags) {
  CheckFlags();
  OfflineOptions options;
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) { schema.AddSection(name, &section); });
  SessionContents tracked;
  if (!FLAGS_session.empty()) {
    tracked = ReadTracked(FLAGS_session);
    schema.LoadYaml(tracked.config, FLAGS_session + ", options");
  }
  const std::string tracking_before = TrackingConfig(options);
  if (!FLAGS_config.empty()) schema.LoadYamlFile(FLAGS_config);
  for (const std::string& assignment : multi_flags.at("set")) schema.ApplyOverride(assignment);
  schema.ValidateAll();
  if (!FLAGS_session.empty() && TrackingConfig(options) != tracking_before) {
    throw UsageError("--config or --set differs from what the session " + FLAGS_session +
                     " was tracked with; with --session only the sections loop, graph, map_refinement, map and cloud "
                     "can be changed");
  }

  if (IsG2oFile(FLAGS_input)) {
    for (const auto& [is_set, flag] :
         {std::pair(FLAGS_odometry_only, "--odometry_only"), std::pair(FLAGS_max_scans > 0, "--max_scans"),
          std::pair(!FLAGS_session.empty(), "--session")}) {
      if (is_set) throw UsageError(std::string(flag) + " is for recordings, and a pose graph is none; leave it out");
    }
    const GraphRun run{FLAGS_input, FLAGS_ground_truth, schema.ToYaml(), NumThreads(), FLAGS_quiet};
    return RunOnGraph(run, options, &PrepareOutput);
  }

  std::optional<Trajectory3> reference;
  if (!FLAGS_ground_truth.empty()) reference = ReadTrajectory(FLAGS_ground_truth);
  const std::unique_ptr<ScanSource> source = OpenScanSource(FLAGS_input, options.input);
  const std::filesystem::path folder = PrepareOutput();

  RunRecord record;
  record.input = FLAGS_input;
  record.num_threads = NumThreads();
  record.odometry_only = FLAGS_odometry_only;
  record.notices = source->Notices();
  if (!FLAGS_quiet) {
    for (const std::string& notice : record.notices) std::cerr << "note: " << notice << "\n";
  }

  std::signal(SIGINT, &OnSignal);
  std::signal(SIGTERM, &OnSignal);
  // A file that may grow no further is an error like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  Stopwatch stopwatch;
  Trajectory3 odometry;
  bool has_sweeps = SkipTracked(source.get(), tracked.read, &record, &odometry);
  const std::unique_ptr<SessionWriter> session = OpenSession(folder, schema.ToYaml(), tracked);
  Slam slam(options.slam, record.num_threads, std::move(tracked), FLAGS_session);
  has_sweeps |= Track(source.get(), &slam, session.get(), &record, &odometry);
  RequireKeyframes(slam, record);
  record.finish = slam.Finish(FLAGS_odometry_only);
  session->Finish(slam, record.finish.sweep_duration ? record.finish.sweep_duration->stamp_shift : 0.0);
  if (record.finish.sweep_duration) TakeDuration(*record.finish.sweep_duration, &record, &odometry);
  record.num_submaps = slam.submaps().size();
  Maps maps;
  if (has_sweeps) {
    maps.plane = ToGridImage(slam.BuildMap());
    RefineMaps(slam, options, &record, &maps);
  } else {
    maps.plane = ToGridImage(slam.BuildMap(options.map.resolution));
  }
  record.wall_seconds = stopwatch.Lap() / 1000.0;
  std::string reference_problem;
  if (reference) reference_problem = EvaluateRun(slam, odometry, *reference, &record);

  // Writing takes moments, and an end amid them would leave temporary files.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  WriteResults(folder, options.slam, slam, odometry, maps, record, schema.ToYaml());
  if (!FLAGS_quiet) std::cout << SummaryText(record) << "results in " << folder.string() << "\n" << std::flush;
  if (record.is_interrupted) {
    std::cerr << "arborslam_offline: interrupted after " << record.scans.size() << " scans; the results in "
              << folder.string() << " cover these\n";
    return kExitSignalled + g_signal;
  }
  if (!record.maps_are_whole) {
    std::cerr << "arborslam_offline: interrupted; the maps in " << folder.string() << " are not whole\n";
    return kExitSignalled + g_signal;
  }
  if (!reference_problem.empty()) {
    throw std::runtime_error(reference_problem + " (the results in " + folder.string() +
                             " are complete but for the errors; arborslam_evaluate can still compare them)");
  }
  return kExitSuccess;
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram({"arborslam_offline", arborslam::kUsage, __FILE__, {"set"}}, argc, argv,
                               &arborslam::Run);
}
