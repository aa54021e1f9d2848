// arborslam_evaluate: the figures of estimated trajectories against their references.

#include <gflags/gflags.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/evaluate/report.h"
#include "core/evaluation/alignment.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/evaluation/trajectory_plot.h"
#include "core/io/atomic_file.h"
#include "core/io/trajectory_io.h"

DEFINE_string(align, "se2", "origin, se2, se3 or none");
DEFINE_string(json, "", "file for the figures");
DEFINE_string(plot, "", "PNG file for the plot");
DEFINE_double(max_time_difference, 0.02, "[s] between poses that belong together");
DEFINE_double(interpolate, 0.0, "[s] gap of the reference that may be interpolated");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_evaluate --estimate FILE [FILE ...] --reference FILE [FILE ...] [flags]

Compares estimated trajectories with their references (TUM text or Pullally .npz) and prints the errors; several runs
get a row each and their mean +- 1.96 sd / sqrt(N).

  --estimate FILE [FILE ...]    trajectories to judge, one a run
  --reference FILE [FILE ...]   their references in the same order, or one for all
  --align KIND                  how an estimate is laid on its reference before errors are taken (default se2):
                                  se2     best fit in the plane (Umeyama, no scale)
                                  se3     best fit in space; only then altitude counts
                                  origin  first poses coincide, in the plane; positions without orientation are taken
                                          to have their first heading along +x
                                  none    not at all
  --max_time_difference S       seconds between the stamps of poses that belong together (default 0.02)
  --interpolate S               interpolate the reference across gaps of up to S seconds (default 0: never)
  --json FILE                   write the figures as JSON: alignment, runs[] and summary, each figure under its name
                                  with its unit (position_rms_m, ate_se2_rmse_m, ...), null where not defined
  --plot FILE.png               draw trajectories and error; of several runs FILE_1.png, FILE_2.png, ...
  --help, --version
)";

void CheckFlags(const MultiFlags& files) {
  const std::vector<std::string>& estimates = files.at("estimate");
  const std::vector<std::string>& references = files.at("reference");
  if (estimates.empty()) throw UsageError("--estimate FILE is missing; see --help");
  if (references.empty()) throw UsageError("--reference FILE is missing; see --help");
  if (references.size() != 1 && references.size() != estimates.size()) {
    throw UsageError("--reference has " + std::to_string(references.size()) + " files for " +
                     std::to_string(estimates.size()) + " of --estimate; give one for each, or one for all");
  }
  if (!ParseAlignmentKind(FLAGS_align)) {
    throw UsageError("--align is '" + FLAGS_align + "' but must be origin, se2, se3 or none");
  }
  for (const auto& [name, value] : {std::pair<const char*, double>{"max_time_difference", FLAGS_max_time_difference},
                                    std::pair<const char*, double>{"interpolate", FLAGS_interpolate}}) {
    if (!std::isfinite(value) || value < 0.0) {
      throw UsageError(std::string("--") + name + " is " + std::to_string(value) + " but must be 0 s or more");
    }
  }
}

EvaluatedRun Evaluate(const std::string& estimate_path, const std::string& reference_path, AlignmentKind alignment,
                      const AssociationOptions& options) {
  EvaluatedRun run{estimate_path, reference_path, {}, {}};
  run.association = Associate(ReadTrajectory(estimate_path), ReadTrajectory(reference_path), options,
                              estimate_path + " against " + reference_path);
  run.evaluation = EvaluateTrajectory(run.association.pairs, run.association.has_headings, alignment);
  return run;
}

// The file for the plot of run `index` of `num_runs`.
std::string PlotPath(size_t index, size_t num_runs) {
  if (num_runs == 1) return FLAGS_plot;
  std::filesystem::path path(FLAGS_plot);
  path.replace_filename(path.stem().string() + "_" + std::to_string(index + 1) + path.extension().string());
  return path.string();
}

// A slip such as `--json run.tum` must not cost the user the run.
void CheckOutputs(const MultiFlags& files) {
  if (!FLAGS_json.empty() && FLAGS_json == FLAGS_plot) {
    throw UsageError("--json and --plot are both '" + FLAGS_json + "'; choose two names");
  }
  std::vector<std::string> outputs;
  if (!FLAGS_json.empty()) outputs.push_back(FLAGS_json);
  const size_t num_runs = files.at("estimate").size();
  for (size_t i = 0; i < num_runs && !FLAGS_plot.empty(); ++i) outputs.push_back(PlotPath(i, num_runs));
  for (const std::string& output : outputs) {
    for (const auto& [flag, inputs] : files) {
      for (const std::string& input : inputs) {
        std::error_code missing;
        if (std::filesystem::equivalent(output, input, missing)) {
          throw UsageError("'" + output + "' would be written over the file of --" + flag + "; choose another name");
        }
      }
    }
  }
}

int Run(const MultiFlags& files) {
  CheckFlags(files);
  CheckOutputs(files);
  const std::vector<std::string>& estimates = files.at("estimate");
  const std::vector<std::string>& references = files.at("reference");
  const AlignmentKind alignment = *ParseAlignmentKind(FLAGS_align);
  AssociationOptions options;
  options.max_time_difference = FLAGS_max_time_difference;
  options.max_interpolation_gap = FLAGS_interpolate;

  std::vector<EvaluatedRun> runs;
  for (size_t i = 0; i < estimates.size(); ++i) {
    runs.push_back(Evaluate(estimates[i], references.size() == 1 ? references[0] : references[i], alignment, options));
  }
  if (!FLAGS_json.empty()) {
    // File names need not be UTF-8, JSON must be.
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    WriteFileAtomically(FLAGS_json, ToJson(runs, options).dump(2, ' ', false, kReplace) + "\n");
  }
  for (size_t i = 0; i < runs.size() && !FLAGS_plot.empty(); ++i) {
    WriteTrajectoryPlot(PlotPath(i, runs.size()), runs[i].evaluation, {runs[i].estimate_path});
  }
  std::cout << FormatTable(runs);
  return kExitSuccess;
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram({"arborslam_evaluate", arborslam::kUsage, __FILE__, {"estimate", "reference"}}, argc,
                               argv, &arborslam::Run);
}
