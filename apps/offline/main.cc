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
#include "apps/offline/graph_run.h"
#include "apps/offline/joint_map.h"
#include "apps/offline/known_session.h"
#include "apps/offline/loop_errors.h"
#include "apps/offline/offline_options.h"
#include "apps/offline/run_figures.h"
#include "apps/offline/run_results.h"
#include "apps/offline/second_pass.h"
#include "apps/offline/summary.h"
#include "backend/merge/known_scans.h"
#include "backend/merge/place_votes.h"
#include "backend/slam.h"
#include "backend/store/fingerprint.h"
#include "backend/store/session_contents.h"
#include "backend/store/session_reader.h"
#include "backend/store/session_writer.h"
#include "core/config/config_schema.h"
#include "core/error.h"
#include "core/io/g2o.h"
#include "core/io/scan_source.h"
#include "core/io/text_reader.h"
#include "core/io/trajectory_io.h"
#include "core/stopwatch.h"
#include "frontend/mounting/levelled_source.h"

DEFINE_string(input, "", "recording to process");
DEFINE_string(output, "", "folder for the results");
DEFINE_string(session, "", "session to go on with");
DEFINE_string(config, "", "YAML file with options");
DEFINE_string(ground_truth, "", "reference trajectory to report errors against");
DEFINE_int32(threads, 0, "threads for loop closure and optimisation, 0: all cores");
DEFINE_bool(odometry_only, false, "close no loops");
DEFINE_int32(max_scans, 0, "stop after this many scans, 0: never");
DEFINE_bool(disjoint, false, "keep the poses of segments that were not joined");
DEFINE_bool(allow_degraded, false, "exit code 0 for a degraded run");
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
  --session FILE.db      goes on with a session, with its options. If --input is the recording that it was made from, an
                         interrupted run goes on to the results of a run in one piece. Another recording of the place
                         is mapped by itself, placed in the session's map and solved together with it: the trajectory
                         is then in the session's frame; map, graph.g2o and session.db are of both. If it finds no
                         certain place, the results are of it alone (exit code 1). FILE.db stays as it is, unless it is
                         DIR/session.db. --set also takes the section 'merge'
  --config FILE.yaml     options; config/default.yaml lists them all; with --session, those of the session come first
  --set SECTION.KEY=VALUE ...
                         one option each, after the file's
  --ground_truth FILE    TUM file or .npz with gnss_rotated_c; for a pose graph also lines of id x y theta, or a .g2o;
                         reported against, never used
  --threads N            for loop closure and optimisation (default, and at most: all cores)
  --odometry_only        close no loops: trajectory.tum is what the sliding window left
  --max_scans N          stop after N scans
  --disjoint             keep the poses of segments that were not joined to the map in trajectory.tum
  --allow_degraded       exit code 0 for a degraded run
  --quiet                print errors only
  --help, --version

Writes trajectory.tum (optimised pose of every scan used), odometry.tum (the causal estimate, as known when the scan
came), map.pgm + map.yaml (ROS map_server), map.png, cloud.ply (3D map, from 3D sweeps), graph.g2o, summary.json
(counts, rejected scans with reasons, loops, times, memory, errors), report.html (all of this for the browser, in one
file) and effective_config.yaml; and, from the first keyframe on, session.db, the run as it goes, from which --session
and arborslam_session start, also when this program was killed (recording.db until the recording is placed in the map
of another session). A pose's stamp is the middle of its sweep. Of a pose graph: trajectory.tum (every vertex, its id
as the stamp), graph.g2o, graph.png, summary.json, report.html and effective_config.yaml.
The last line, summary.json and the report say whether to trust the result: ok (exit code 0), degraded (3: parts, which
it names, were lost) or lost (4: most was). Ctrl-C ends the reading early
and keeps what there is (exit code 130), but makes no 3D map; a second one ends the program at once.
)";

// After an interruption the exit code is this and the signal's number, as shells have it.
constexpr int kExitSignalled = 128;

constexpr char kSessionFile[] = "session.db";
// A recording's own session, until it is part of that of several.
constexpr char kRecordingFile[] = "recording.db";
constexpr std::array<const char*, 12> kResultFiles = {"trajectory.tum",
                                                      "odometry.tum",
                                                      "map.yaml",
                                                      "map.pgm",
                                                      "map.png",
                                                      "cloud.ply",
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

bool AreSameFile(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  return std::filesystem::equivalent(a, b, error);
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
    if (!IsSameScan(*scan, read[i])) {
      throw UserError(
          FLAGS_input,
          "scan " + std::to_string(i + 1) + " is not the one that the session " + FLAGS_session + " was made from",
          "give the recording that the session was made from as it was then");
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

// Feeds the recording, which may have no scan that is among the `known` ones, to `slam` and the session; fills the
// record's scans and the causal trajectory. True if the scans are in space.
bool Track(ScanSource* source, const KnownScans& known, Slam* slam, SessionWriter* session, RunRecord* record,
           Trajectory3* odometry) {
  std::optional<size_t> total = source->NumScans();
  if (total && FLAGS_max_scans > 0) total = std::min(*total, static_cast<size_t>(FLAGS_max_scans));
  ProgressBar progress(std::cerr, total, StderrIsTerminal() && !FLAGS_quiet);
  bool has_sweeps = false;
  while (g_signal == 0 && (FLAGS_max_scans == 0 || record->scans.size() < static_cast<size_t>(FLAGS_max_scans))) {
    const std::optional<Scan> scan = NextScan(source, *slam, session);
    if (!scan) break;
    has_sweeps = std::holds_alternative<LidarSweep>(*scan);
    const uint64_t fingerprint = FingerprintOf(*scan);
    if (known.Hold(fingerprint)) {
      session->Discard();
      throw UserError(
          FLAGS_input,
          "scan " + std::to_string(record->scans.size() + 1) + " is in the session " + FLAGS_session + " already",
          "give each recording once");
    }
    record->scans.push_back(std::visit([slam](const auto& any) { return slam->AddScan(any); }, *scan));
    const ScanResult& result = record->scans.back();
    session->Add(fingerprint, result, *slam);
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

// Judges the run, and marks its scans by how they got their final poses: some that were rejected when they came have
// been measured since, others are in no map.
void JudgeScans(RunRecord* record) {
  const FinishResult& finish = record->finish;
  const std::vector<size_t> indices = PosedIndices(*record);
  record->verdict = JudgeRun(finish.pose_sources, finish.segments, indices);
  const std::vector<bool> placed = PlacedScans(finish.pose_sources, finish.segments);
  for (size_t i = 0; i < indices.size(); ++i) {
    ScanResult& scan = record->scans[indices[i]];
    const bool is_measured = finish.pose_sources[i] == PoseSource::kMeasured;
    if (is_measured && placed[i]) {
      scan.status = ScanStatus::kMatched;
      scan.reason.clear();
    } else if (scan.status == ScanStatus::kMatched) {
      scan.status = ScanStatus::kPredicted;
      scan.reason = is_measured ? "in a segment that was not joined to the map" : "not found in the final map";
    }
  }
}

// Leaves out the poses of scans that have none in the map; with --disjoint only those that are guesses.
template <class Poses>
void KeepPlaced(const FinishResult& finish, Poses* poses) {
  const std::vector<bool> placed = PlacedScans(finish.pose_sources, finish.segments);
  Poses kept;
  for (size_t i = 0; i < poses->size(); ++i) {
    if (placed[i] || (FLAGS_disjoint && finish.pose_sources[i] == PoseSource::kMeasured)) kept.push_back((*poses)[i]);
  }
  *poses = std::move(kept);
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

// Fills the record's errors; `tracked` is the graph before it was finished. Returns what is wrong with the reference,
// or "": a run is not to be lost for it.
std::string EvaluateRun(const Slam& slam, const PoseGraph& tracked, const Trajectory3& trajectory,
                        const Trajectory3& odometry, const Trajectory3& reference, RunRecord* record) {
  const auto associate = [&reference](const Trajectory3& estimate) {
    return Associate(estimate, reference, AssociationOptions{}, FLAGS_input + " and " + FLAGS_ground_truth);
  };
  const auto evaluate = [](const AssociationResult& pairs) {
    return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2);
  };
  try {
    RunErrors errors;
    const AssociationResult trajectory_pairs = associate(trajectory);
    const AssociationResult odometry_pairs = associate(odometry);
    errors.trajectory = evaluate(trajectory_pairs);
    errors.odometry = evaluate(odometry_pairs);
    errors.unmatched_poses = odometry_pairs.unmatched_estimate;
    if (trajectory_pairs.has_headings) {
      errors.loops = EvaluateLoops(record->finish.loops, slam.submaps(), slam.scans(), tracked, trajectory_pairs.pairs);
    }
    record->errors = std::move(errors);
    return "";
  } catch (const UserError& error) {
    record->notices.push_back(std::string("No errors against the ground truth: ") + error.what() + ".");
    return error.what();
  }
}

// Says what a map lacks, and why.
void NoteMapProblem(const std::string& text, RunRecord* record) {
  record->notices.push_back(text);
  if (!FLAGS_quiet) std::cerr << "note: " << text << "\n";
}

// Reads a recording of sweeps again for the maps that need all of their points. What it cannot make is left as it is,
// and why goes to the record's notices: a run is not to be lost for it.
void RefineMaps(const OfflineOptions& options, RunRecord* record, RunResults* results) {
  std::optional<Cloud> cloud;
  if (options.cloud.enabled) cloud.emplace(options.cloud, options.slam.reduction.deskew);
  std::optional<Footprints> footprints;
  if (options.map.resolution > 0.0 && options.map.resolution < options.slam.grid.cell_size) {
    if (results->paths.size() > 1) {
      NoteMapProblem("The map is coarser than map.resolution: that needs the sweeps of all recordings.", record);
    } else {
      footprints.emplace(results->map, options.map, options.slam);
    }
  }
  if (!cloud && !footprints) return;
  Stopwatch stopwatch;
  std::string problem;
  try {
    ProgressBar progress(std::cerr, record->scans.size(), StderrIsTerminal() && !FLAGS_quiet);
    const bool is_whole = g_signal == 0 && VisitMatchedSweeps(
                                               OpenLevelledSource(FLAGS_input, options.input).get(), record->scans,
                                               record->finish.sweep_duration, results->trajectory,
                                               [&](const PosedSweep& sweep) {
                                                 if (cloud) cloud->Add(sweep);
                                                 if (footprints) footprints->Add(sweep);
                                               },
                                               [&progress](size_t num_read) {
                                                 progress.Update(num_read);
                                                 return g_signal == 0;
                                               });
    if (is_whole) {
      if (footprints) results->map = footprints->Image();
      if (cloud) results->cloud = cloud->Points();
    } else {
      problem = "interrupted";
      record->maps_are_whole = false;
    }
  } catch (const UserError& error) {
    problem = error.what();
  }
  record->maps_ms = stopwatch.Lap();
  if (!results->cloud.empty()) {
    record->cloud = CloudRecord{cloud->num_sweeps(), results->cloud.size(), cloud->voxel_size()};
  } else if (cloud && problem.empty()) {
    problem = "no place was met by as many sweeps as cloud.min_sweeps asks for";
  }
  if (problem.empty()) return;
  NoteMapProblem((cloud ? "No 3D map" : "The map is coarser than map.resolution") + (": " + problem) + ".", record);
}

// The options that scans are tracked by: those of all sections but those that only the end of a run reads.
std::string TrackingConfig(OfflineOptions options) {
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) {
    for (const char* last : {"loop", "place", "graph", "map_refinement", "map", "cloud", "memory"}) {
      if (name == last) return;
    }
    schema.AddSection(name, &section);
  });
  return schema.ToYaml();
}

// The session of this run at `path`: a new one, or, with --session, that one or a copy of it, which holds `known`.
std::unique_ptr<SessionWriter> OpenSession(const std::string& path, const std::string& config,
                                           const KnownSession& known) {
  if (FLAGS_session.empty() || known.map) return SessionWriter::Create(path, config, FLAGS_input);
  if (AreSameFile(FLAGS_session, path)) return SessionWriter::Continue(path, known.tracked);
  return SessionWriter::ContinueCopy(FLAGS_session, path, known.tracked);
}

// Leaves in `folder` the session that a recording, new to that of --session, has come to: `joint`, or its own one.
// Returns the file's name.
std::string KeepJointSession(const std::filesystem::path& folder, const SessionContents* joint) {
  const std::string own = (folder / kRecordingFile).string();
  const std::string session = (folder / kSessionFile).string();
  if (joint != nullptr) {
    WriteSession(session, *joint);
    std::error_code ignored;
    std::filesystem::remove(own, ignored);
    return kSessionFile;
  }
  if (AreSameFile(FLAGS_session, session)) return kRecordingFile;
  MoveSession(own, session);
  return kSessionFile;
}

int Run(const MultiFlags& multi_flags) {
  CheckFlags();
  OfflineOptions options;
  MergeOptions merge;
  ConfigSchema session_schema;
  options.VisitSections([&](const std::string& name, auto& section) { session_schema.AddSection(name, &section); });
  ConfigSchema schema = session_schema;
  if (!FLAGS_session.empty()) {
    schema.AddSection("merge", &merge);
    schema.LoadYaml(ReadSessionSummary(FLAGS_session).config, FLAGS_session + ", options");
  }
  const std::string tracking_before = TrackingConfig(options);
  if (!FLAGS_config.empty()) schema.LoadYamlFile(FLAGS_config);
  for (const std::string& assignment : multi_flags.at("set")) schema.ApplyOverride(assignment);
  schema.ValidateAll();
  if (!FLAGS_session.empty() && TrackingConfig(options) != tracking_before) {
    throw UsageError("--config or --set differs from what the session " + FLAGS_session +
                     " was tracked with; with --session only the sections loop, graph, map_refinement, map, cloud, "
                     "memory, place and merge can be changed");
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
  const std::unique_ptr<ScanSource> source = OpenLevelledSource(FLAGS_input, options.input);
  const std::shared_ptr<ValueStore> store = MakeStore(options.memory);
  KnownSession known;
  if (!FLAGS_session.empty()) {
    known = ReadKnownSession(FLAGS_session, FLAGS_input, OpenLevelledSource(FLAGS_input, options.input)->Next(), store);
  }
  const bool is_new = known.map.has_value();
  if (is_new && FLAGS_odometry_only) {
    throw UsageError("--odometry_only closes no loops, but " + FLAGS_input + " is to be placed in the map of " +
                     FLAGS_session + ", which does; leave one of the two out");
  }
  const std::filesystem::path folder = PrepareOutput();
  if (is_new) PrepareOutputFolder(FLAGS_output, {kRecordingFile}, {FLAGS_session, FLAGS_input, FLAGS_ground_truth});

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
  bool has_sweeps = SkipTracked(source.get(), known.tracked.read, &record, &odometry);
  const std::string session_path = (folder / (is_new ? kRecordingFile : kSessionFile)).string();
  const std::unique_ptr<SessionWriter> session = OpenSession(session_path, session_schema.ToYaml(), known);
  Slam slam(options.slam, record.num_threads, std::move(known.tracked), FLAGS_session, store);
  const KnownScans known_scans = is_new ? KnownScans(*known.map) : KnownScans();
  has_sweeps |= Track(source.get(), known_scans, &slam, session.get(), &record, &odometry);
  RequireKeyframes(slam, record);
  const PoseGraph tracked = reference ? slam.graph() : PoseGraph();
  record.finish = slam.Finish(FLAGS_odometry_only);
  session->Finish(slam, record.finish.sweep_duration ? record.finish.sweep_duration->stamp_shift : 0.0);
  if (record.finish.sweep_duration) TakeDuration(*record.finish.sweep_duration, &record, &odometry);
  record.num_submaps = slam.submaps().size();
  JudgeScans(&record);
  JointMap joint;
  // A part of a recording is not placed: the rest could not follow.
  if (is_new && !record.is_interrupted) {
    joint = Join(options.slam, merge, record.num_threads, FLAGS_session, std::move(*known.map),
                 ReadSession(session_path, store));
    record.join = joint.record;
  }
  const double cell_size = has_sweeps ? 0.0 : options.map.resolution;
  RunResults results = ResultsOf(slam, odometry, cell_size);
  if (joint.contents) {
    joint.contents->config = session_schema.ToYaml();
    results = ResultsOf(*joint.contents, odometry, options.slam, cell_size);
    record.notices.push_back("The map is that of " + std::to_string(joint.contents->recordings.size()) +
                             " recordings; scans and loops are those of the last one, which " + TextOf(joint.record) +
                             ".");
  }
  if (has_sweeps) RefineMaps(options, &record, &results);
  KeepPlaced(record.finish, &results.trajectory.poses);
  KeepPlaced(record.finish, &results.paths.back());
  record.wall_seconds = stopwatch.Lap() / 1000.0;
  std::string reference_problem;
  if (reference) reference_problem = EvaluateRun(slam, tracked, results.trajectory, odometry, *reference, &record);

  // Writing takes moments, and an end amid them would leave temporary files.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  WriteResults(folder, options.slam, slam.submaps(), results, record, (is_new ? schema : session_schema).ToYaml());
  std::string kept_session = kSessionFile;
  if (is_new) kept_session = KeepJointSession(folder, joint.contents ? &*joint.contents : nullptr);
  if (!FLAGS_quiet) {
    std::cout << SummaryText(record) << "results in " << folder.string() << "\n";
    std::cout << "verdict: " << TextOf(record.verdict) << "\n" << std::flush;
  }
  if (FLAGS_quiet && record.verdict.state != RunState::kOk) {
    std::cerr << "arborslam_offline: verdict: " << TextOf(record.verdict) << "\n";
  }
  if (record.is_interrupted) {
    std::cerr << "arborslam_offline: interrupted after " << record.scans.size() << " scans"
              << (is_new ? " and not placed in the map of " + FLAGS_session : "") << "; the results in "
              << folder.string() << " cover these"
              << (is_new ? " alone, their session is " + (folder / kept_session).string() : "") << "\n";
    return kExitSignalled + g_signal;
  }
  if (is_new && !joint.contents) {
    throw UserError(FLAGS_input, "has " + TextOf(joint.record),
                    "give a recording of the same site whose path overlaps; the results in " + folder.string() +
                        " are those of this recording alone, its session is " + (folder / kept_session).string());
  }
  if (!record.maps_are_whole) {
    std::cerr << "arborslam_offline: interrupted; the maps in " << folder.string() << " are not whole\n";
    return kExitSignalled + g_signal;
  }
  if (!reference_problem.empty()) {
    throw std::runtime_error(reference_problem + " (the results in " + folder.string() +
                             " are complete but for the errors; arborslam_evaluate can still compare them)");
  }
  if (record.verdict.state == RunState::kLost) return kExitLost;
  return record.verdict.state == RunState::kOk || FLAGS_allow_degraded ? kExitSuccess : kExitDegraded;
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram({"arborslam_offline", arborslam::kUsage, __FILE__, {"set"}}, argc, argv,
                               &arborslam::Run);
}
