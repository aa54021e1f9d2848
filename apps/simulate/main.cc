// arborslam_simulate: recordings of simulated worlds with their exact ground truth.

#include <gflags/gflags.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/common/progress_bar.h"
#include "core/config/config_schema.h"
#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/npz.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/planar_orchard.h"

DEFINE_string(scenario, "", "planar_orchard");
DEFINE_string(output, "", "folder for the results");
DEFINE_int32(seed, 1, "everything random follows from it");
DEFINE_int32(scans, 0, "number of scans, 0: once around");
DEFINE_string(config, "", "YAML file with the options of the scenario");
DEFINE_bool(quiet, false, "print errors only");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_simulate --scenario planar_orchard --output DIR [flags]

Simulates a robot with a lidar and writes into DIR: scans.npz (what it sees, for arborslam_offline), ground_truth.tum
(where it was, exactly) and simulation.yaml (the options in effect). Equal options give equal results on any machine.

  --scenario NAME          planar_orchard: rows of trees seen by a planar lidar on a legged robot
  --output DIR             created if it does not exist
  --seed N                 everything random follows from it (default 1)
  --scans N                number of scans (default: as many as lead once around the path)
  --config FILE.yaml       options of the scenario
  --set planar_orchard.KEY=VALUE ...
                           one option each, after the file's; simulation.yaml lists them all
  --quiet                  print errors only
  --help, --version
)";

constexpr char kPlanarOrchard[] = "planar_orchard";
// What NpzFile reads at most.
constexpr double kMaxArrayBytes = 2147483648.0;

bool IsGiven(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

void CheckFlags() {
  if (FLAGS_scenario.empty()) throw UsageError("--scenario NAME is missing; the scenarios are: planar_orchard");
  if (FLAGS_scenario != kPlanarOrchard) {
    throw UsageError("--scenario is '" + FLAGS_scenario + "'; the scenarios are: planar_orchard");
  }
  if (FLAGS_output.empty()) throw UsageError("--output DIR is missing; see --help");
  if (FLAGS_seed < 0) throw UsageError("--seed is " + std::to_string(FLAGS_seed) + " but must be 0 or more");
  if (IsGiven("scans") && FLAGS_scans < 1) {
    throw UsageError("--scans is " + std::to_string(FLAGS_scans) + " but must be 1 or more");
  }
}

void Configure(const std::vector<std::string>& overrides, ConfigSchema* schema) {
  if (!FLAGS_config.empty()) schema->LoadYamlFile(FLAGS_config);
  for (const std::string& assignment : overrides) schema->ApplyOverride(assignment);
  if (IsGiven("seed")) schema->ApplyOverride("planar_orchard.seed=" + std::to_string(FLAGS_seed));
  if (IsGiven("scans")) schema->ApplyOverride("planar_orchard.num_scans=" + std::to_string(FLAGS_scans));
  schema->ValidateAll();
}

void MakeFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path)) {
    const std::string reason = error ? " (" + error.message() + ")" : "";
    throw UserError(path, "cannot be made a folder" + reason, "choose another --output");
  }
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

int Run(const MultiFlags& multi_flags) {
  CheckFlags();
  PlanarOrchardOptions options;
  ConfigSchema schema;
  schema.AddSection(kPlanarOrchard, &options);
  Configure(multi_flags.at("set"), &schema);
  const PlanarOrchard orchard(options);
  const double bytes = 8.0 * static_cast<double>(orchard.NumScans()) * options.lidar.beams;
  if (bytes > kMaxArrayBytes) {
    throw UserError("scans.npz", std::to_string(orchard.NumScans()) + " scans are too many for one file",
                    "ask for fewer scans or beams");
  }

  MakeFolder(FLAGS_output);
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

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  return arborslam::RunProgram({"arborslam_simulate", arborslam::kUsage, __FILE__, {"set"}}, argc, argv,
                               &arborslam::Run);
}
