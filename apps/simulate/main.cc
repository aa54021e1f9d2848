// arborslam_simulate: recordings of simulated worlds with their exact ground truth.

#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/common/output_folder.h"
#include "apps/common/program.h"
#include "apps/common/progress_bar.h"
#include "apps/simulate/recording.h"
#include "core/config/config_schema.h"
#include "core/config/edit_distance.h"
#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/npz.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/citrus.h"
#include "core/simulation/cones.h"
#include "core/simulation/forest.h"
#include "core/simulation/orchard.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/simulated_run.h"
#include "core/simulation/vineyard.h"

DEFINE_string(scenario, "", "cones, citrus, vineyard, orchard, forest or planar_orchard");
DEFINE_string(output, "", "folder for the results");
DEFINE_int32(seed, 1, "everything random follows from it");
DEFINE_int32(scans, 0, "number of scans, 0: once around");
DEFINE_string(format, "bin", "of the sweeps: bin or pcd");
DEFINE_string(config, "", "YAML file with the options of the scenario");
DEFINE_bool(quiet, false, "print errors only");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_simulate --scenario NAME --output DIR [flags]

Simulates a lidar that is carried through a world of plants and writes what it sees, with the exact truth, into DIR.
Equal options give equal results on any machine.

  --scenario cones         traffic cones on a lawn, VLP-16 on a legged robot, 16 m
             citrus        a grove of citrus trees, VLP-16 on a wheeled robot, 865 m
             vineyard      rows of vines, OS1-16 on a wheeled robot, 102 m
             orchard       rows of mixed trees, VLP-16 on a legged robot that people follow, 150 m
             forest        a natural forest, VLP-16 in the hand, 400 m
             planar_orchard  rows of trees seen by a planar lidar on a legged robot: scans.npz instead of sweeps
  --output DIR             created if it does not exist. In it: clouds/ (raw sweeps), timestamps.txt (their starts),
                           ground_truth.tum (T_world_lidar in the middle of each sweep), gt_map.yaml, controls.csv
                           (odometry) and simulation.yaml (the options in effect)
  --format bin|pcd         of the sweeps: x, y, z, intensity as in the KITTI data sets (default), or with point times
  --seed N                 everything random follows from it (default 1)
  --scans N                number of scans (default: as many as lead once around the path)
  --config FILE.yaml       options of the scenario
  --set SCENARIO.KEY=VALUE ...  one option each, after the file's; simulation.yaml lists them all
  --quiet                  print errors only
  --help, --version
)";

constexpr char kPlanarOrchard[] = "planar_orchard";
// What NpzFile reads at most.
constexpr double kMaxArrayBytes = 2147483648.0;

bool IsGiven(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

const std::vector<std::string>& Scenarios() {
  static const auto* const names =
      new std::vector<std::string>{"cones", "citrus", "vineyard", "orchard", "forest", kPlanarOrchard};
  return *names;
}

void CheckFlags() {
  std::string names;
  for (const std::string& name : Scenarios()) names += (names.empty() ? "" : ", ") + name;
  if (FLAGS_scenario.empty()) throw UsageError("--scenario NAME is missing; the scenarios are: " + names);
  if (std::find(Scenarios().begin(), Scenarios().end(), FLAGS_scenario) == Scenarios().end()) {
    throw UsageError("--scenario is '" + FLAGS_scenario + "'; did you mean '" +
                     NearestName(FLAGS_scenario, Scenarios()) + "'? The scenarios are: " + names);
  }
  if (FLAGS_output.empty()) throw UsageError("--output DIR is missing; see --help");
  if (FLAGS_seed < 0) throw UsageError("--seed is " + std::to_string(FLAGS_seed) + " but must be 0 or more");
  if (IsGiven("scans") && FLAGS_scans < 1) {
    throw UsageError("--scans is " + std::to_string(FLAGS_scans) + " but must be 1 or more");
  }
  if (FLAGS_format != "bin" && FLAGS_format != "pcd") {
    throw UsageError("--format is '" + FLAGS_format + "' but must be bin or pcd");
  }
  if (IsGiven("format") && FLAGS_scenario == kPlanarOrchard) {
    throw UsageError("--format is for sweeps, and planar_orchard has none; leave it out");
  }
}

void Configure(const std::vector<std::string>& overrides, ConfigSchema* schema) {
  if (!FLAGS_config.empty()) schema->LoadYamlFile(FLAGS_config);
  for (const std::string& assignment : overrides) schema->ApplyOverride(assignment);
  if (IsGiven("seed")) schema->ApplyOverride(FLAGS_scenario + ".seed=" + std::to_string(FLAGS_seed));
  if (IsGiven("scans")) schema->ApplyOverride(FLAGS_scenario + ".num_scans=" + std::to_string(FLAGS_scans));
  schema->ValidateAll();
}

// The scans in the layout of the Pullally recordings.
std::map<std::string, NpyArray> Record(const PlanarOrchard& orchard, size_t num_beams) {
  NpyArray ranges{{orchard.NumScans(), num_beams}, {}};
  NpyArray stamps{{orchard.NumScans()}, {}};
  ranges.values.reserve(orchard.NumScans() * num_beams);
  ProgressBar progress(std::cerr, orchard.NumScans(), StderrIsTerminal() && !FLAGS_quiet);
  for (size_t i = 0; i < orchard.NumScans(); ++i) {
    const LaserScan scan = orchard.Scan(i);
    ranges.values.insert(ranges.values.end(), scan.ranges.begin(), scan.ranges.end());
    stamps.values.push_back(scan.stamp);
    progress.Update(i + 1);
  }
  std::map<std::string, NpyArray> arrays;
  arrays["scan0"] = std::move(ranges);
  arrays["time"] = std::move(stamps);
  return arrays;
}

int RunPlanarOrchard(const std::vector<std::string>& overrides) {
  PlanarOrchardOptions options;
  ConfigSchema schema;
  schema.AddSection(kPlanarOrchard, &options);
  Configure(overrides, &schema);
  const PlanarOrchard orchard(options);
  const double bytes = 8.0 * static_cast<double>(orchard.NumScans()) * options.lidar.beams;
  if (bytes > kMaxArrayBytes) {
    throw UserError("scans.npz", std::to_string(orchard.NumScans()) + " scans are too many for one file",
                    "ask for fewer scans or beams");
  }

  MakeOutputFolder(FLAGS_output);
  const std::filesystem::path folder(FLAGS_output);
  WriteNpz((folder / "scans.npz").string(), Record(orchard, static_cast<size_t>(options.lidar.beams)));
  WriteTum((folder / "ground_truth.tum").string(), orchard.GroundTruth());
  WriteFileAtomically((folder / "simulation.yaml").string(), schema.ToYaml());
  if (!FLAGS_quiet) {
    std::cout << orchard.NumScans() << " scans among " << orchard.trunks().size() << " trees, path of "
              << std::lround(orchard.PathLength()) << " m: " << (folder / "scans.npz").string() << ", "
              << (folder / "ground_truth.tum").string() << "\n";
  }
  return kExitSuccess;
}

// A scenario in space: its options and the world that they make.
template <class Options>
int RunInSpace(const std::vector<std::string>& overrides, Scene (*make_scene)(const Options&)) {
  Options options;
  ConfigSchema schema;
  schema.AddSection(FLAGS_scenario, &options);
  Configure(overrides, &schema);
  const SimulatedRun run(options.run, make_scene(options));
  MakeOutputFolder(FLAGS_output);
  const std::filesystem::path folder(FLAGS_output);
  ProgressBar progress(std::cerr, run.NumScans(), StderrIsTerminal() && !FLAGS_quiet);
  const SweepFormat format = FLAGS_format == "pcd" ? SweepFormat::kPcd : SweepFormat::kBin;
  WriteRecording(run, folder, format, [&](size_t count) { progress.Update(count); });
  WriteFileAtomically((folder / "simulation.yaml").string(), schema.ToYaml());
  if (!FLAGS_quiet) {
    std::cout << run.NumScans() << " sweeps among " << run.world().solids.size() << " solids, path of "
              << std::lround(run.PathLength()) << " m: " << (folder / "clouds").string() << ", "
              << (folder / "ground_truth.tum").string() << "\n";
  }
  return kExitSuccess;
}

int Run(const MultiFlags& multi_flags) {
  CheckFlags();
  const std::vector<std::string>& overrides = multi_flags.at("set");
  if (FLAGS_scenario == "cones") return RunInSpace<ConesOptions>(overrides, &MakeCones);
  if (FLAGS_scenario == "citrus") return RunInSpace<CitrusOptions>(overrides, &MakeCitrus);
  if (FLAGS_scenario == "vineyard") return RunInSpace<VineyardOptions>(overrides, &MakeVineyard);
  if (FLAGS_scenario == "orchard") return RunInSpace<OrchardOptions>(overrides, &MakeOrchard);
  if (FLAGS_scenario == "forest") return RunInSpace<ForestOptions>(overrides, &MakeForest);
  return RunPlanarOrchard(overrides);
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram({"arborslam_simulate", arborslam::kUsage, __FILE__, {"set"}}, argc, argv,
                               &arborslam::Run);
}
