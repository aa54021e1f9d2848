#include "apps/offline/graph_run.h"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "apps/common/program.h"
#include "apps/offline/graph_picture.h"
#include "apps/offline/graph_record.h"
#include "backend/graph/graph_smoother.h"
#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/g2o.h"
#include "core/io/png.h"
#include "core/io/trajectory_io.h"
#include "core/io/vertex_poses.h"
#include "core/stopwatch.h"

namespace arborslam {
namespace {

constexpr size_t kMaxListed = 5;

Trajectory3 VerticesOf(const PoseGraph2& graph) {
  Trajectory trajectory;
  trajectory.reserve(graph.vertices.size());
  for (const auto& [id, pose] : graph.vertices) trajectory.push_back({static_cast<double>(id), pose});
  return ToTrajectory3(trajectory);
}

// What the user should know of the graph.
std::vector<std::string> Notices(const SmoothedGraph& smoothed) {
  std::vector<std::string> notices;
  if (smoothed.num_parts > 1) {
    std::string held;
    for (size_t i = 0; i < std::min(smoothed.held.size(), kMaxListed); ++i) {
      held += (i > 0 ? ", " : "") + std::to_string(smoothed.held[i]);
    }
    notices.push_back("The graph is in " + std::to_string(smoothed.num_parts) +
                      " parts that no edge joins; each is smoothed for itself, with a vertex held (" + held +
                      (smoothed.held.size() > kMaxListed ? ", ..." : "") + ").");
  }
  if (!smoothed.graph.fixed.empty()) {
    notices.push_back(std::to_string(smoothed.graph.fixed.size()) + " vertices are held by FIX records.");
  }
  return notices;
}

TrajectoryEvaluation Evaluate(const PoseGraph2& graph, const Trajectory3& reference, const GraphRun& run,
                              size_t* unmatched) {
  const AssociationResult pairs =
      Associate(VerticesOf(graph), reference, AssociationOptions{}, run.input + " and " + run.ground_truth);
  *unmatched = pairs.unmatched_estimate;
  return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2);
}

// Fills the record's errors. Returns what is wrong with the reference, or "".
std::string EvaluateRun(const PoseGraph2& given, const Trajectory3& reference, const GraphRun& run,
                        GraphRecord* record) {
  try {
    GraphErrors errors;
    errors.given = Evaluate(given, reference, run, &errors.unmatched_vertices);
    errors.smoothed = Evaluate(record->smoothed.graph, reference, run, &errors.unmatched_vertices);
    record->errors = std::move(errors);
    return "";
  } catch (const UserError& error) {
    record->notices.push_back(std::string("No errors against the ground truth: ") + error.what() + ".");
    return error.what();
  }
}

void WriteResults(const std::filesystem::path& folder, const GraphRecord& record, const std::string& effective_config) {
  const SmoothedGraph& smoothed = record.smoothed;
  WriteG2o((folder / "graph.g2o").string(), smoothed.graph);
  WriteTum((folder / "trajectory.tum").string(), VerticesOf(smoothed.graph), "id of the vertex");
  const std::string picture_path = (folder / "graph.png").string();
  WritePng(picture_path, DrawGraph(smoothed.graph, smoothed.dropped_loops, smoothed.held));
  std::ifstream file(picture_path, std::ios::binary);
  const std::string picture{std::istreambuf_iterator<char>(file), {}};
  WriteFileAtomically((folder / "effective_config.yaml").string(), effective_config);
  WriteFileAtomically((folder / "summary.json").string(), GraphSummaryJson(record));
  WriteFileAtomically((folder / "report.html").string(), GraphReportHtml(record, picture, effective_config));
  // Of an earlier run on a recording; they would be taken for this one's.
  for (const char* name : {"odometry.tum", "map.yaml", "map.pgm", "map.png", "cloud.ply"}) {
    std::error_code ignored;
    std::filesystem::remove(folder / name, ignored);
  }
}

}  // namespace

int RunOnGraph(const GraphRun& run, const OfflineOptions& options,
               const std::function<std::filesystem::path()>& prepare_output) {
  Stopwatch stopwatch;
  std::optional<Trajectory3> reference;
  if (!run.ground_truth.empty()) reference = ReadVertexPoses(run.ground_truth);
  stopwatch.Lap();
  const PoseGraph2 given = ReadG2o(run.input);
  GraphRecord record;
  record.read_ms = stopwatch.Lap();
  const std::filesystem::path folder = prepare_output();

  record.input = run.input;
  record.num_threads = run.num_threads;
  record.robust = options.smoothing.robust;
  stopwatch.Lap();
  record.smoothed = SmoothGraph(given, options.smoothing, options.slam.graph, run.num_threads);
  record.solve_ms = stopwatch.Lap();
  record.notices = Notices(record.smoothed);
  std::string reference_problem;
  if (reference) reference_problem = EvaluateRun(given, *reference, run, &record);
  WriteResults(folder, record, run.effective_config);
  if (!run.quiet) {
    for (const std::string& notice : record.notices) std::cerr << "note: " << notice << "\n";
    std::cout << GraphSummaryText(record) << "results in " << folder.string() << "\n" << std::flush;
  }
  if (!reference_problem.empty()) {
    throw std::runtime_error(reference_problem + " (the results in " + folder.string() +
                             " are complete but for the errors)");
  }
  return kExitSuccess;
}

}  // namespace arborslam
