// arborslam_evaluate: the figures of estimated trajectories and maps against their references.

#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/evaluate/evaluated_run.h"
#include "apps/evaluate/offline_summary.h"
#include "apps/evaluate/report.h"
#include "core/evaluation/alignment.h"
#include "core/evaluation/association.h"
#include "core/evaluation/map_metrics.h"
#include "core/evaluation/relations.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/evaluation/trajectory_plot.h"
#include "core/io/atomic_file.h"
#include "core/io/map_io.h"
#include "core/io/trajectory_io.h"

DEFINE_string(align, "se2", "origin, se2, se3 or none");
DEFINE_bool(common_alignment, false, "one alignment for all runs");
DEFINE_string(json, "", "file for the figures");
DEFINE_string(markdown, "", "file for the table in Markdown");
DEFINE_string(plot, "", "PNG file for the plot");
DEFINE_double(max_time_difference, 0.02, "[s] between poses that belong together");
DEFINE_double(interpolate, 0.0, "[s] gap of the reference that may be interpolated");
DEFINE_double(map_tolerance, 0.0, "[m] between cells of maps that agree");
DEFINE_bool(map_beyond_is_unknown, false, "judge no cells beyond the edges of the reference map");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_evaluate [--estimate FILE ... --reference FILE ... --relations FILE ...]
                          [--map FILE ... --map_reference FILE ...] [flags]

Compares estimated trajectories (TUM text or Pullally .npz) and occupancy maps with their references and prints the
errors; several runs get a row each and their mean +- 1.96 sd / sqrt(N).

  --estimate FILE [FILE ...]    trajectories to judge, one a run
  --reference FILE [FILE ...]   their references in the same order, or one for all
  --align KIND                  how an estimate is laid on its reference before errors are taken (default se2):
                                  se2     best fit in the plane (Umeyama, no scale); heights agree in the mean
                                  se3     best fit in space; altitude counts as x and y do
                                  origin  first poses coincide, in the plane and in height; positions without
                                          orientation are taken to have their first heading along +x
                                  none    not at all
  --common_alignment            one alignment for all runs, whose estimates are in one frame, such as the trajectories
                                of a merged session, and whose references are too; also prints the ATE of all runs
                                together. Of a .npz the reference is gnss_data (UTM east, north), the same for all
  --max_time_difference S       seconds between the stamps of poses that belong together (default 0.02)
  --interpolate S               interpolate the reference across gaps of up to S seconds (default 0: never)
  --relations FILE [FILE ...]   relative poses t1 t2 x y z roll pitch yaw (Kuemmerle et al. 2009) to hold the estimates
                                against, one file for each or one for all; with or instead of --reference
  --map FILE [FILE ...]         map.yaml to judge (ROS map_server), one a run; moved as its trajectory is by --align,
                                in the plane (se3: as by se2), or compared as it lies if there is none
  --map_reference FILE [...]    their references, or one for all: precision, sensitivity and accuracy on its grid
  --map_tolerance M             occupied cells agree if their centres are no more than M metres apart (default 0)
  --map_beyond_is_unknown       do not judge what a map has beyond the edges of its reference (default: it is false)
  --summary FILE [FILE ...]     the runs' summary.json, for time, memory and the error of odometry.tum
  --json FILE                   write the figures as JSON: alignment, runs[] and summary, each figure under its name
                                with its unit (position_rms_m, ate_se2_rmse_m, ...), null where not defined
  --markdown FILE               write the table of runs in Markdown
  --columns NAME [NAME ...]     only these figures in table and Markdown, by their names in the JSON
  --labels TEXT [TEXT ...]      what to call the runs (default 1, 2, ...)
  --plot FILE.png               draw trajectories and error; of several runs FILE_1.png, FILE_2.png, ...
  --help, --version
)";

// A flag that gives one reference for each file of another, or one for all.
void CheckReferences(const MultiFlags& files, const std::string& name, const std::string& reference_name) {
  const size_t count = files.at(name).size();
  const size_t reference_count = files.at(reference_name).size();
  if (count == 0) throw UsageError("--" + name + " FILE is missing; see --help");
  if (reference_count == 0) throw UsageError("--" + reference_name + " FILE is missing; see --help");
  if (reference_count != 1 && reference_count != count) {
    throw UsageError("--" + reference_name + " has " + std::to_string(reference_count) + " files for " +
                     std::to_string(count) + " of --" + name + "; give one for each, or one for all");
  }
}

bool IsGiven(const MultiFlags& files, const std::string& name) { return !files.at(name).empty(); }

// One flag of a pair asks for both. Nothing at all is taken for a trajectory that is missing.
bool WantsMaps(const MultiFlags& files) { return IsGiven(files, "map") || IsGiven(files, "map_reference"); }
bool WantsRelations(const MultiFlags& files) { return IsGiven(files, "relations"); }
bool WantsTrajectories(const MultiFlags& files) {
  if (IsGiven(files, "reference")) return true;
  return !WantsRelations(files) && (IsGiven(files, "estimate") || !WantsMaps(files));
}

size_t NumRuns(const MultiFlags& files) {
  return files.at(WantsTrajectories(files) || WantsRelations(files) ? "estimate" : "map").size();
}

void CheckFlags(const MultiFlags& files) {
  if (WantsTrajectories(files)) CheckReferences(files, "estimate", "reference");
  if (WantsRelations(files)) CheckReferences(files, "estimate", "relations");
  if (WantsMaps(files)) CheckReferences(files, "map", "map_reference");
  for (const char* name : {"map", "summary", "labels"}) {
    const size_t count = files.at(name).size();
    if (count != 0 && count != NumRuns(files)) {
      throw UsageError(std::string("--") + name + " has " + std::to_string(count) + " values for " +
                       std::to_string(NumRuns(files)) + " runs; give one for each");
    }
  }
  if (!WantsTrajectories(files) && !FLAGS_plot.empty()) {
    throw UsageError("--plot draws trajectories; give --estimate and --reference");
  }
  if (!WantsTrajectories(files) && FLAGS_common_alignment) {
    throw UsageError("--common_alignment is of trajectories; give --estimate and --reference");
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
  if (!std::isfinite(FLAGS_map_tolerance) || FLAGS_map_tolerance < 0.0) {
    throw UsageError("--map_tolerance is " + std::to_string(FLAGS_map_tolerance) + " but must be 0 m or more");
  }
}

// The value of the flag `name` for run `index`; one value serves all runs.
const std::string& Nth(const MultiFlags& files, const std::string& name, size_t index) {
  const std::vector<std::string>& values = files.at(name);
  return values.size() == 1 ? values[0] : values[index];
}

EvaluatedTrajectory ReadTrajectoryFiles(const std::string& estimate_path, const std::string& reference_path,
                                        const EvaluationSettings& settings) {
  EvaluatedTrajectory trajectory{estimate_path, reference_path, {}, {}};
  const ReferenceFrame frame = settings.common_alignment ? ReferenceFrame::kOfSite : ReferenceFrame::kOfRun;
  trajectory.association = Associate(ReadTrajectory(estimate_path), ReadTrajectory(reference_path, frame),
                                     settings.association, estimate_path + " against " + reference_path);
  return trajectory;
}

EvaluatedRelations EvaluateRelationFiles(const std::string& estimate_path, const std::string& relations_path,
                                         const EvaluationSettings& settings) {
  return {estimate_path, relations_path,
          EvaluateRelations(ReadTrajectory(estimate_path), ReadRelations(relations_path),
                            settings.association.max_time_difference, estimate_path + " against " + relations_path)};
}

// The motion of the plane that lays a map on its reference as its trajectory is laid on that's.
SE2 PlanarAlignment(const std::optional<EvaluatedTrajectory>& trajectory, AlignmentKind kind) {
  if (!trajectory) return SE2();
  // Best in space is not best in the plane: a far origin would lean the map out of its place.
  const Eigen::Isometry3d& T = kind == AlignmentKind::kSe3 ? trajectory->evaluation.T_reference_estimate_se2
                                                           : trajectory->evaluation.T_reference_estimate;
  return SE2(T.translation().x(), T.translation().y(), Heading(Eigen::Quaterniond(T.linear())));
}

EvaluatedMap EvaluateMapFiles(const std::string& map_path, const std::string& reference_path,
                              const SE2& T_reference_map, const EvaluationSettings& settings) {
  EvaluatedMap map{map_path, reference_path, T_reference_map, {}};
  map.metrics = CompareMaps(ReadMapServer(map_path), ReadMapServer(reference_path), T_reference_map, settings.map,
                            map_path + " against " + reference_path);
  return map;
}

// Measures the trajectories of `runs`, each after an alignment of its own or all after one.
std::optional<JointEvaluation> EvaluateTrajectories(const EvaluationSettings& settings,
                                                    std::vector<EvaluatedRun>* runs) {
  if (!settings.common_alignment) {
    for (EvaluatedRun& run : *runs) {
      const AssociationResult& association = run.trajectory->association;
      run.trajectory->evaluation = EvaluateTrajectory(association.pairs, association.has_headings, settings.alignment);
    }
    return std::nullopt;
  }
  std::vector<RunPairs> pairs;
  for (const EvaluatedRun& run : *runs) {
    pairs.push_back({run.trajectory->association.pairs, run.trajectory->association.has_headings});
  }
  JointEvaluation joint = EvaluateTogether(pairs, settings.alignment);
  for (size_t i = 0; i < runs->size(); ++i) (*runs)[i].trajectory->evaluation = joint.runs[i];
  return joint;
}

std::vector<EvaluatedRun> EvaluateRuns(const MultiFlags& files, const EvaluationSettings& settings,
                                       std::optional<JointEvaluation>* joint) {
  std::vector<EvaluatedRun> runs(NumRuns(files));
  for (size_t i = 0; i < runs.size(); ++i) {
    runs[i].label = IsGiven(files, "labels") ? files.at("labels")[i] : std::to_string(i + 1);
    if (!WantsTrajectories(files)) continue;
    runs[i].trajectory = ReadTrajectoryFiles(files.at("estimate")[i], Nth(files, "reference", i), settings);
  }
  if (WantsTrajectories(files)) *joint = EvaluateTrajectories(settings, &runs);
  for (size_t i = 0; i < runs.size(); ++i) {
    EvaluatedRun& run = runs[i];
    if (WantsRelations(files)) {
      run.relations = EvaluateRelationFiles(files.at("estimate")[i], Nth(files, "relations", i), settings);
    }
    if (WantsMaps(files)) {
      run.map = EvaluateMapFiles(files.at("map")[i], Nth(files, "map_reference", i),
                                 PlanarAlignment(run.trajectory, settings.alignment), settings);
    }
    if (IsGiven(files, "summary")) run.offline_summary = ReadOfflineSummary(files.at("summary")[i]);
  }
  return runs;
}

// The figures of --columns, in its order.
std::vector<Figure> ParseColumns(const std::vector<std::string>& columns) {
  std::vector<Figure> figures;
  for (const std::string& column : columns) {
    const auto figure = std::find_if(AllFigures().begin(), AllFigures().end(),
                                     [&column](const Figure& candidate) { return candidate.key == column; });
    if (figure == AllFigures().end()) {
      std::string known;
      for (const Figure& candidate : AllFigures()) known += (known.empty() ? "" : ", ") + candidate.key;
      throw UsageError("--columns has '" + column + "', which is none of: " + known);
    }
    figures.push_back(*figure);
  }
  return figures;
}

// What to print when --columns does not say: in a table, only what some run has.
std::vector<Figure> DefaultFigures(const std::vector<EvaluatedRun>& runs) {
  std::vector<Figure> figures = FiguresOf(runs);
  if (runs.size() == 1) return figures;
  const auto is_absent = [&runs](const Figure& figure) {
    return std::none_of(runs.begin(), runs.end(),
                        [&figure](const EvaluatedRun& run) { return figure.value(run).has_value(); });
  };
  figures.erase(std::remove_if(figures.begin(), figures.end(), is_absent), figures.end());
  return figures;
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
  std::vector<std::pair<std::string, std::string>> outputs;  // Flag and file.
  if (!FLAGS_json.empty()) outputs.emplace_back("--json", FLAGS_json);
  if (!FLAGS_markdown.empty()) outputs.emplace_back("--markdown", FLAGS_markdown);
  const size_t num_runs = NumRuns(files);
  for (size_t i = 0; i < num_runs && !FLAGS_plot.empty(); ++i) outputs.emplace_back("--plot", PlotPath(i, num_runs));
  for (size_t i = 0; i < outputs.size(); ++i) {
    const auto& [flag, output] = outputs[i];
    for (size_t k = 0; k < i; ++k) {
      if (outputs[k].second == output) {
        throw UsageError(outputs[k].first + " and " + flag + " are both '" + output + "'; choose two names");
      }
    }
    for (const char* input_flag : {"estimate", "reference", "relations", "map", "map_reference", "summary"}) {
      for (const std::string& input : files.at(input_flag)) {
        std::error_code missing;
        if (std::filesystem::equivalent(output, input, missing)) {
          throw UsageError("'" + output + "' would be written over the file of --" + input_flag +
                           "; choose another name");
        }
      }
    }
  }
}

int Run(const MultiFlags& files) {
  CheckFlags(files);
  CheckOutputs(files);
  const std::vector<Figure> columns = ParseColumns(files.at("columns"));
  EvaluationSettings settings;
  settings.alignment = *ParseAlignmentKind(FLAGS_align);
  settings.common_alignment = FLAGS_common_alignment;
  settings.association.max_time_difference = FLAGS_max_time_difference;
  settings.association.max_interpolation_gap = FLAGS_interpolate;
  settings.map.tolerance = FLAGS_map_tolerance;
  settings.map.beyond_is_unknown = FLAGS_map_beyond_is_unknown;

  std::optional<JointEvaluation> joint;
  const std::vector<EvaluatedRun> runs = EvaluateRuns(files, settings, &joint);
  const std::vector<Figure> figures = columns.empty() ? DefaultFigures(runs) : columns;
  if (!FLAGS_json.empty()) {
    // File names need not be UTF-8, JSON must be.
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    WriteFileAtomically(FLAGS_json, ToJson(runs, settings, joint).dump(2, ' ', false, kReplace) + "\n");
  }
  if (!FLAGS_markdown.empty()) WriteFileAtomically(FLAGS_markdown, FormatMarkdown(runs, figures));
  for (size_t i = 0; i < runs.size() && !FLAGS_plot.empty(); ++i) {
    const EvaluatedTrajectory& trajectory = *runs[i].trajectory;
    WriteTrajectoryPlot(PlotPath(i, runs.size()), trajectory.evaluation,
                        {IsGiven(files, "labels") ? runs[i].label : trajectory.estimate_path});
  }
  std::cout << FormatTable(runs, figures, settings, joint);
  return kExitSuccess;
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram(
      {"arborslam_evaluate",
       arborslam::kUsage,
       __FILE__,
       {"estimate", "reference", "relations", "map", "map_reference", "summary", "columns", "labels"}},
      argc, argv, &arborslam::Run);
}
