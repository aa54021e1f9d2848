// Runs the program itself, on recordings of a simulated orchard.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/g2o.h"
#include "core/io/map_io.h"
#include "core/io/npz.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/planar_orchard.h"
#include "tests/apps/program_test.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const std::set<std::string> kResults = {
    "effective_config.yaml", "graph.g2o",   "map.pgm",    "map.png",      "map.yaml",
    "odometry.tum",          "report.html", "session.db", "summary.json", "trajectory.tum"};

// What is recorded, before it is written.
struct Recording {
  size_t num_beams = 0;
  std::vector<std::vector<double>> ranges;  // One vector a scan.
  std::vector<double> stamps;

  std::map<std::string, NpyArray> Arrays() const {
    NpyArray scans{{ranges.size(), num_beams}, {}};
    for (const std::vector<double>& scan : ranges) scans.values.insert(scans.values.end(), scan.begin(), scan.end());
    return {{"scan0", scans}, {"time", {{stamps.size()}, stamps}}};
  }
};

// `num_scans` of them; 0: once around, so that there is a loop.
PlanarOrchard Orchard(int num_scans) {
  PlanarOrchardOptions options;
  options.seed = 5;
  options.rows = 3;
  options.trees_per_row = 7;
  options.lidar.beams = 449;
  options.num_scans = num_scans;
  return PlanarOrchard(options);
}

Recording Record(const PlanarOrchard& orchard) {
  Recording recording;
  for (size_t i = 0; i < orchard.NumScans(); ++i) {
    const LaserScan scan = orchard.Scan(i);
    recording.num_beams = scan.ranges.size();
    recording.ranges.emplace_back(scan.ranges.begin(), scan.ranges.end());
    recording.stamps.push_back(scan.stamp);
  }
  return recording;
}

class OfflineTest : public ProgramTest {
 protected:
  using ProgramTest::Write;
  void Write(const std::string& name, const std::map<std::string, NpyArray>& arrays) const {
    WriteNpz(Path(name).string(), arrays);
  }

  // run.npz: a short recording without a loop.
  void WriteShortRun() const { Write("run.npz", Record(Orchard(30)).Arrays()); }
  // run.npz and truth.tum: once around.
  void WriteLoop() const {
    const PlanarOrchard orchard = Orchard(0);
    Write("run.npz", Record(orchard).Arrays());
    WriteTum(Path("truth.tum").string(), orchard.GroundTruth());
  }

  Outcome Run(const std::string& arguments, const std::string& before = "") const {
    return ProgramTest::Run("arborslam_offline", arguments, before);
  }
  Outcome RunWell(const std::string& arguments) const { return ProgramTest::RunWell("arborslam_offline", arguments); }

  std::set<std::string> Files(const std::string& name) const {
    std::set<std::string> files;
    if (!fs::is_directory(Path(name))) return files;
    for (const fs::directory_entry& entry : fs::directory_iterator(Path(name))) {
      files.insert(entry.path().filename().string());
    }
    return files;
  }

  std::string Result(const std::string& output, const std::string& name) const { return ReadFile(Path(output) / name); }

  nlohmann::json Summary(const std::string& output) const {
    return nlohmann::json::parse(Result(output, "summary.json"), nullptr, false);
  }

  Trajectory3 ReadResult(const std::string& output, const std::string& name) const {
    return ReadTrajectory((Path(output) / name).string());
  }

  static void ExpectOneLine(const Outcome& outcome, const std::vector<std::string>& parts) {
    ProgramTest::ExpectOneLine("arborslam_offline", outcome, parts);
  }

  // The program fails with one line on stderr that holds all `parts`, and leaves nothing in out/.
  void ExpectError(const std::string& arguments, int exit_code, const std::vector<std::string>& parts) const {
    const Outcome outcome = ProgramTest::ExpectError("arborslam_offline", arguments, exit_code, parts);
    EXPECT_EQ(outcome.out, "") << arguments;
    EXPECT_EQ(Files("out"), std::set<std::string>()) << arguments;
  }

  double AteRmse(const fs::path& estimate, const fs::path& truth) const {
    const AssociationResult pairs =
        Associate(ReadTrajectory(estimate.string()), ReadTrajectory(truth.string()), AssociationOptions(), "the test");
    return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2).metrics.ate_rmse;
  }

  // The counts of summary.json add up.
  static void ExpectConsistent(const nlohmann::json& summary, size_t num_scans) {
    ASSERT_FALSE(summary.is_discarded());
    const nlohmann::json& scans = summary.at("scans");
    EXPECT_EQ(scans.at("read"), num_scans);
    const size_t matched = scans.at("matched");
    const size_t rejected = scans.at("rejected");
    const size_t skipped = scans.at("skipped");
    EXPECT_EQ(matched + rejected + skipped, num_scans);
    EXPECT_EQ(summary.at("unused_scans").size(), rejected + skipped);
    for (const nlohmann::json& scan : summary.at("unused_scans")) EXPECT_NE(scan.at("reason"), "");
    size_t accepted = 0;
    for (const nlohmann::json& loop : summary.at("loops").at("candidates")) {
      accepted += loop.at("accepted").get<bool>() ? 1 : 0;
      EXPECT_EQ(loop.at("accepted").get<bool>(), loop.at("reason") == "");
    }
    EXPECT_EQ(summary.at("loops").at("accepted"), accepted);
    EXPECT_EQ(summary.at("loops").at("tried"), summary.at("loops").at("candidates").size());
  }
};

TEST_F(OfflineTest, HelpIsShortAndNamesEveryFlagAndFile) {
  const Outcome outcome = RunWell("--help");
  EXPECT_LT(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 40);
  for (const char* flag : {"--input", "--output", "--session", "--config", "--set", "--ground_truth", "--threads",
                           "--odometry_only", "--max_scans", "--quiet", "--help", "--version"}) {
    EXPECT_NE(outcome.out.find(flag), std::string::npos) << flag;
  }
  for (const std::string& file : kResults) EXPECT_NE(outcome.out.find(file), std::string::npos) << file;
}

TEST_F(OfflineTest, WritesAllResults) {
  WriteLoop();
  const size_t num_scans = Orchard(0).NumScans();
  const Outcome outcome = RunWell("--input run.npz --output deep/out --ground_truth truth.tum --threads 2");
  EXPECT_NE(outcome.out.find("results in deep/out"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("SE(2)-aligned"), std::string::npos) << outcome.out;
  // Exactly these: nothing temporary is left.
  EXPECT_EQ(Files("deep/out"), kResults);

  ASSERT_EQ(ReadResult("deep/out", "trajectory.tum").poses.size(), num_scans);
  ASSERT_EQ(ReadResult("deep/out", "odometry.tum").poses.size(), num_scans);
  const double ate_rmse = AteRmse(Path("deep/out/trajectory.tum"), Path("truth.tum"));
  EXPECT_LT(ate_rmse, 0.15);
  EXPECT_LT(AteRmse(Path("deep/out/odometry.tum"), Path("truth.tum")), 0.3);

  const nlohmann::json summary = Summary("deep/out");
  ExpectConsistent(summary, num_scans);
  EXPECT_EQ(summary.at("input"), "run.npz");
  EXPECT_FALSE(summary.at("interrupted").get<bool>());
  EXPECT_FALSE(summary.at("odometry_only").get<bool>());
  EXPECT_GT(summary.at("loops").at("accepted").get<int>(), 0);
  EXPECT_GT(summary.at("submaps").get<int>(), 1);
  EXPECT_GT(summary.at("peak_memory_mib").get<double>(), 1.0);
  for (const char* stage : {"scan_total", "project", "match", "window", "insert"}) {
    const nlohmann::json& time = summary.at("time_ms").at(stage);
    EXPECT_LE(time.at("median"), time.at("p95")) << stage;
    EXPECT_LE(time.at("p95"), time.at("max")) << stage;
  }
  for (const char* stage : {"loop_search", "optimization", "map_refinement", "run"}) {
    EXPECT_GT(summary.at("time_ms").at(stage).get<double>(), 0.0) << stage;
  }
  const nlohmann::json& errors = summary.at("errors");
  EXPECT_EQ(errors.at("unmatched_poses"), 0);
  EXPECT_EQ(errors.at("trajectory").at("alignment"), "se2");
  EXPECT_NEAR(errors.at("trajectory").at("ate_se2_rmse_m").get<double>(), ate_rmse, 1e-6);
  EXPECT_GT(errors.at("odometry").at("ate_se2_rmse_m").get<double>(), 0.0);

  const PoseGraph2 graph = ReadG2o(Path("deep/out/graph.g2o").string());
  EXPECT_EQ(graph.vertices.size(),
            summary.at("scans").at("keyframes").get<size_t>() + summary.at("submaps").get<size_t>());
  EXPECT_GE(graph.edges.size(), graph.vertices.size() - 1);

  const GridImage map = ReadMapServer(Path("deep/out/map.yaml").string());
  EXPECT_NEAR(map.resolution, 0.05, 1e-9);
  EXPECT_GT(std::count(map.occupancy.begin(), map.occupancy.end(), 100), 100);
  EXPECT_GT(std::count(map.occupancy.begin(), map.occupancy.end(), 0), 10000);
  EXPECT_EQ(Result("deep/out", "map.png").rfind("\x89PNG", 0), 0u);
}

TEST_F(OfflineTest, EqualToTheByteForAnyNumberOfThreadsAndWithoutGroundTruth) {
  WriteLoop();
  RunWell("--input run.npz --output first --threads 1");
  RunWell("--input run.npz --output again --threads 1");
  RunWell("--input run.npz --output two --threads 2 --ground_truth truth.tum");
  RunWell("--input run.npz --output all --threads 0");
  RunWell("--input run.npz --output many --threads 1024");
  for (const char* output : {"again", "two", "all", "many"}) {
    for (const std::string& file : kResults) {
      // Times differ.
      if (file == "summary.json" || file == "report.html" || file == "session.db") continue;
      EXPECT_FALSE(Result("first", file).empty()) << file;
      EXPECT_TRUE(Result(output, file) == Result("first", file)) << output << "/" << file;
    }
    EXPECT_EQ(Summary(output).at("loops"), Summary("first").at("loops"));
  }
  EXPECT_FALSE(Summary("first").contains("errors"));
  EXPECT_TRUE(Summary("two").contains("errors"));
}

TEST_F(OfflineTest, ItsOwnConfigurationRepeatsTheRun) {
  WriteShortRun();
  RunWell("--input run.npz --output plain");
  RunWell(
      "--input run.npz --output first --set projection.max_range=9.5 grid.cell_size=0.1 --set motion.model=unicycle");
  RunWell("--input run.npz --output second --config first/effective_config.yaml");
  EXPECT_TRUE(Result("first", "trajectory.tum") == Result("second", "trajectory.tum"));
  EXPECT_TRUE(Result("first", "effective_config.yaml") == Result("second", "effective_config.yaml"));
  EXPECT_FALSE(Result("first", "trajectory.tum") == Result("plain", "trajectory.tum"));
  const std::string config = Result("first", "effective_config.yaml");
  for (const char* line : {"max_range: 9.5\n", "cell_size: 0.1\n", "model: unicycle\n"}) {
    EXPECT_NE(config.find(line), std::string::npos) << config;
  }
  EXPECT_NEAR(ReadMapServer(Path("first/map.yaml").string()).resolution, 0.1, 1e-9);
  // An override comes after the file, and a folder with results may be written to again, from its own configuration.
  RunWell(
      "--input run.npz --output first --config first/effective_config.yaml --set projection.max_range=15.0 "
      "grid.cell_size=0.05 motion.model=omnidirectional");
  EXPECT_TRUE(Result("first", "trajectory.tum") == Result("plain", "trajectory.tum"));
  EXPECT_EQ(Files("first"), kResults);
}

TEST_F(OfflineTest, TheShippedDefaultsChangeNothing) {
  WriteShortRun();
  RunWell("--input run.npz --output plain");
  for (const char* preset : {"default", "pullally"}) {
    RunWell("--input run.npz --output preset --config '" ARBORSLAM_SOURCE_DIR "/config/" + std::string(preset) +
            ".yaml'");
    EXPECT_TRUE(Result("preset", "trajectory.tum") == Result("plain", "trajectory.tum")) << preset;
    EXPECT_TRUE(Result("preset", "effective_config.yaml") == Result("plain", "effective_config.yaml")) << preset;
  }
}

TEST_F(OfflineTest, OdometryOnlyClosesNoLoops) {
  WriteLoop();
  RunWell("--input run.npz --output with");
  RunWell("--input run.npz --output without --odometry_only");
  EXPECT_TRUE(Result("without", "odometry.tum") == Result("with", "odometry.tum"));
  EXPECT_FALSE(Result("without", "trajectory.tum") == Result("with", "trajectory.tum"));
  const nlohmann::json summary = Summary("without");
  EXPECT_TRUE(summary.at("odometry_only").get<bool>());
  EXPECT_EQ(summary.at("loops").at("tried"), 0);
  EXPECT_EQ(Files("without"), kResults);
}

TEST_F(OfflineTest, MaxScansAndQuiet) {
  WriteShortRun();
  EXPECT_EQ(RunWell("--input run.npz --output five --max_scans 5 --quiet").out, "");
  ExpectConsistent(Summary("five"), 5);
  EXPECT_EQ(ReadResult("five", "trajectory.tum").poses.size(), 5u);
  RunWell("--input run.npz --output more --max_scans 1000");
  ExpectConsistent(Summary("more"), 30);
}

TEST_F(OfflineTest, NamesNeedNotBeUtf8) {
  WriteShortRun();
  fs::rename(Path("run.npz"), Path("r\xe9n.npz"));
  RunWell("--input 'r\xe9n.npz' --output out --max_scans 2");
  EXPECT_EQ(Files("out"), kResults);
  EXPECT_EQ(Summary("out").at("input"), "r\xef\xbf\xbdn.npz");
}

TEST_F(OfflineTest, OneScan) {
  WriteShortRun();
  RunWell("--input run.npz --output out --max_scans 1");
  EXPECT_EQ(Files("out"), kResults);
  ExpectConsistent(Summary("out"), 1);
  const Trajectory3 trajectory = ReadResult("out", "trajectory.tum");
  ASSERT_EQ(trajectory.poses.size(), 1u);
  EXPECT_LT(trajectory.poses[0].position.norm(), 1e-6);
}

TEST_F(OfflineTest, GroundTruthInTheRecordingIsNeverUsed) {
  const PlanarOrchard orchard = Orchard(40);
  const Recording recording = Record(orchard);
  NpyArray positions{{orchard.NumScans(), 2}, {}};
  for (size_t i = 0; i < orchard.NumScans(); ++i) {
    positions.values.insert(positions.values.end(), {orchard.TruePose(i).x(), orchard.TruePose(i).y()});
  }
  std::map<std::string, NpyArray> arrays = recording.Arrays();
  Write("without.npz", arrays);
  arrays["gnss_rotated_c"] = positions;
  Write("with.npz", arrays);
  // Positions that are elsewhere altogether change nothing but the errors.
  for (double& value : arrays["gnss_rotated_c"].values) value *= -3.0;
  Write("wrong.npz", arrays);
  RunWell("--input with.npz --output with --ground_truth with.npz");
  RunWell("--input wrong.npz --output wrong --ground_truth wrong.npz");
  RunWell("--input without.npz --output without");
  for (const char* file : {"trajectory.tum", "odometry.tum", "graph.g2o", "map.pgm"}) {
    EXPECT_TRUE(Result("with", file) == Result("without", file)) << file;
    EXPECT_TRUE(Result("wrong", file) == Result("without", file)) << file;
  }
  EXPECT_LT(Summary("with").at("errors").at("trajectory").at("ate_se2_rmse_m"), 0.15);
  EXPECT_GT(Summary("wrong").at("errors").at("trajectory").at("ate_se2_rmse_m"), 1.0);
  // Positions have no headings.
  EXPECT_FALSE(Summary("with").at("errors").at("trajectory").contains("heading_rms_rad"));
}

// Hours of work are not lost because the reference does not fit.
TEST_F(OfflineTest, GroundTruthOfAnotherTimeCostsOnlyTheErrors) {
  WriteShortRun();
  Write("late.tum", "1000 0 0 0 0 0 0 1\n1001 1 0 0 0 0 0 1\n");
  const Outcome outcome = Run("--input run.npz --output results --ground_truth late.tum");
  EXPECT_EQ(outcome.exit_code, 1);
  ExpectOneLine(outcome, {"run.npz and late.tum", "no stamps match", "results in results are complete"});
  EXPECT_EQ(Files("results"), kResults);
  const nlohmann::json summary = Summary("results");
  ExpectConsistent(summary, 30);
  EXPECT_FALSE(summary.contains("errors"));
  ASSERT_EQ(summary.at("notices").size(), 1u);
  EXPECT_NE(summary.at("notices").at(0).get<std::string>().find("no stamps match"), std::string::npos);
}

TEST_F(OfflineTest, ScansThatSayNothingAreRejectedAndStated) {
  const PlanarOrchard orchard = Orchard(40);
  Recording recording = Record(orchard);
  for (const size_t i : {0u, 15u, 16u}) recording.ranges[i].assign(recording.num_beams, kInfinity);
  recording.ranges[25].assign(recording.num_beams, std::nan(""));
  for (size_t beam = 0; beam < recording.num_beams; beam += 7) recording.ranges[30][beam] = std::nan("");
  recording.ranges[31][5] = -1.0;
  recording.ranges[31][6] = 1e300;
  Write("run.npz", recording.Arrays());
  WriteTum(Path("truth.tum").string(), orchard.GroundTruth());
  const Outcome outcome = Run("--input run.npz --output out --ground_truth truth.tum");
  // Three of 39: more than happens now and then.
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  const std::string verdict = "verdict: degraded: 3 of 39 scans were not matched, most in a row scans 16 to 17\n";
  EXPECT_EQ(outcome.out.substr(outcome.out.size() - verdict.size()), verdict);
  EXPECT_EQ(outcome.err.rfind("note: ", 0), 0u) << outcome.err;
  EXPECT_NE(outcome.err.find("negative or not a number"), std::string::npos) << outcome.err;
  const nlohmann::json summary = Summary("out");
  ExpectConsistent(summary, 40);
  EXPECT_EQ(summary.at("notices").size(), 1u);
  std::map<size_t, nlohmann::json> unused;
  for (const nlohmann::json& scan : summary.at("unused_scans")) unused[scan.at("index")] = scan;
  ASSERT_EQ(unused.count(0), 1u);
  EXPECT_EQ(unused[0].at("status"), "skipped");
  for (const size_t i : {15u, 16u, 25u}) {
    ASSERT_EQ(unused.count(i), 1u) << i;
    EXPECT_EQ(unused[i].at("status"), "rejected");
    EXPECT_EQ(unused[i].at("reason"), "too few points");
    EXPECT_EQ(unused[i].at("pose"), "interpolated");
  }
  EXPECT_EQ(ReadResult("out", "trajectory.tum").poses.size(), 39u);
  EXPECT_LT(summary.at("errors").at("trajectory").at("ate_se2_max_m"), 0.4);
  EXPECT_EQ(summary.at("verdict").at("state"), "degraded");
  // --quiet keeps the notes back too, but not that the result is in doubt.
  const Outcome quiet = Run("--input run.npz --output quiet --quiet --allow_degraded");
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.out, "");
  EXPECT_EQ(quiet.err, "arborslam_offline: " + verdict);
}

TEST_F(OfflineTest, StampsThatDoNotRiseAreRepairedAndStated) {
  Recording recording = Record(Orchard(30));
  recording.stamps[10] = recording.stamps[9];
  recording.stamps[20] = recording.stamps[3];
  Write("run.npz", recording.Arrays());
  const Outcome outcome = Run("--input run.npz --output out");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err,
            "note: 2 of the 30 stamps are not later than the one before: 2 are replaced by ones between their "
            "neighbours', and no scan is lost.\n");
  const nlohmann::json summary = Summary("out");
  ExpectConsistent(summary, 30);
  EXPECT_EQ(summary.at("scans").at("skipped"), 0);
  EXPECT_EQ(ReadResult("out", "trajectory.tum").poses.size(), 30u);
}

TEST_F(OfflineTest, StampsThatAllRunBackwardsAreCounted) {
  Recording recording = Record(Orchard(10));
  std::reverse(recording.stamps.begin(), recording.stamps.end());
  Write("run.npz", recording.Arrays());
  const Outcome outcome = Run("--input run.npz --output out");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("they are taken to be 1 s apart"), std::string::npos) << outcome.err;
  EXPECT_EQ(Summary("out").at("scans").at("skipped"), 0);
}

TEST_F(OfflineTest, RefusesCommandLinesThatCannotBeUsed) {
  WriteShortRun();
  ExpectError("", 2, {"--input PATH is missing", "--help"});
  ExpectError("--input run.npz", 2, {"--output DIR is missing"});
  ExpectError("--input --output out", 2, {"--input needs a value"});
  const std::string valid = "--input run.npz --output out ";
  ExpectError(valid + "--threads -1", 2, {"--threads is -1", "[0, 1024]"});
  ExpectError(valid + "--threads abc", 2, {"--threads is 'abc'", "whole number"});
  ExpectError(valid + "--threads 1.5", 2, {"--threads is '1.5'", "whole number"});
  ExpectError(valid + "--max_scans -3", 2, {"--max_scans is -3", "0 or more"});
  ExpectError(valid + "--thread 2", 2, {"unknown flag --thread", "--threads"});
  ExpectError(valid + "--flagfile x", 2, {"unknown flag --flagfile"});
  ExpectError(valid + "extra", 2, {"'extra' belongs to no flag"});
  ExpectError(valid + "--set", 2, {"--set needs at least one value"});
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(OfflineTest, RefusesConfigurationsThatCannotBeUsed) {
  WriteShortRun();
  const std::string valid = "--input run.npz --output out ";
  ExpectError(valid + "--config none.yaml", 1, {"none.yaml: no such configuration file"});
  Write("key.yaml", "tracker:\n  wide_scor: 0.1\n");
  ExpectError(valid + "--config key.yaml", 1, {"key.yaml:2", "unknown key 'wide_scor'", "wide_score"});
  Write("section.yaml", "traker:\n  wide_score: 0.1\n");
  ExpectError(valid + "--config section.yaml", 1, {"section.yaml:1", "unknown section 'traker'", "tracker"});
  Write("range.yaml", "mhd:\n  alpha_min: 1.3\n");
  ExpectError(valid + "--config range.yaml", 1, {"range.yaml:2", "alpha_min is 1.3"});
  Write("type.yaml", "window:\n  num_keyframes: many\n");
  ExpectError(valid + "--config type.yaml", 1, {"type.yaml:2", "num_keyframes is 'many'", "integer"});
  Write("syntax.yaml", "mhd: [\n");
  ExpectError(valid + "--config syntax.yaml", 1, {"syntax.yaml", "not valid YAML"});
  ExpectError(valid + "--config run.npz", 1, {"run.npz"});
  ExpectError(valid + "--set wide_score=1", 1, {"--set wide_score=1", "tracker.wide_score"});
  ExpectError(valid + "--set tracker.wide_score", 1, {"has no '='"});
  ExpectError(valid + "--set grid.cell_size=nan", 1, {"grid.cell_size", "finite number"});
  ExpectError(valid + "--set grid.cell_size=0", 1, {"grid.cell_size=0", "[0.001, 1]"});
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(OfflineTest, RefusesInputsThatCannotBeRead) {
  const std::string output = " --output out";
  ExpectError("--input none.npz" + output, 1, {"none.npz: does not exist"});
  fs::create_directories(Path("folder"));
  ExpectError("--input folder" + output, 1, {"folder: is a folder without a recording"});
  Write("empty.npz", "");
  ExpectError("--input empty.npz" + output, 1, {"empty.npz: is empty"});
  Write("text.npz", "no recording\n");
  ExpectError("--input text.npz" + output, 1, {"text.npz: is of no known format"});
  Write("other.npz", {{"time", {{2}, {0.0, 1.0}}}});
  ExpectError("--input other.npz" + output, 1, {"other.npz", "without scans", "'time'"});
  Write("no_scans.npz", {{"scan0", {{0, 100}, {}}}});
  ExpectError("--input no_scans.npz" + output, 1, {"no_scans.npz", "scan0", "(0, 100)"});
  Write("stamps.npz", {{"scan0", {{2, 2}, {1, 1, 1, 1}}}, {"time", {{3}, {0, 1, 2}}}});
  ExpectError("--input stamps.npz" + output, 1, {"stamps.npz", "time", "(3,)"});
  WriteShortRun();
  const std::string whole = ReadFile(Path("run.npz"));
  Write("cut.npz", whole.substr(0, whole.size() / 2));
  ExpectError("--input cut.npz" + output, 1, {"cut.npz"});
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(OfflineTest, RefusesRecordingsWithoutASingleUsableScan) {
  Recording recording = Record(Orchard(5));
  for (std::vector<double>& scan : recording.ranges) scan.assign(recording.num_beams, kInfinity);
  Write("empty.npz", recording.Arrays());
  ExpectError("--input empty.npz --output out", 1,
              {"empty.npz", "none of its 5 scans has enough returns", "projection"});
  Write("two_beams.npz", {{"scan0", {{2, 2}, {1, 1, 1, 1}}}, {"time", {{2}, {0, 1}}}});
  ExpectError("--input two_beams.npz --output out", 1, {"two_beams.npz", "none of its 2 scans"});
}

TEST_F(OfflineTest, ARunThatComesToNothingLeavesEarlierResultsAlone) {
  WriteShortRun();
  RunWell("--input run.npz --output results");
  std::map<std::string, std::string> before;
  for (const std::string& file : kResults) before[file] = Result("results", file);
  Recording recording = Record(Orchard(5));
  for (std::vector<double>& scan : recording.ranges) scan.assign(recording.num_beams, kInfinity);
  Write("empty.npz", recording.Arrays());
  ExpectError("--input empty.npz --output results", 1, {"empty.npz", "none of its 5 scans"});
  ExpectError("--input none.npz --output results", 1, {"none.npz: does not exist"});
  // Nor does one that goes on with a session it was not made from.
  RunWell("--input run.npz --output part --max_scans 20");
  Write("short.npz", Record(Orchard(10)).Arrays());
  ExpectError("--session part/session.db --input short.npz --output results", 1, {"short.npz"});
  EXPECT_EQ(Files("results"), kResults);
  for (const auto& [file, bytes] : before) EXPECT_TRUE(Result("results", file) == bytes) << file;
}

TEST_F(OfflineTest, RefusesGroundTruthThatCannotBeReadBeforeAnyWork) {
  WriteShortRun();
  const std::string valid = "--input run.npz --output out ";
  ExpectError(valid + "--ground_truth none.tum", 1, {"none.tum: does not exist"});
  ExpectError(valid + "--ground_truth run.npz", 1, {"run.npz", "gnss_rotated_c"});
  Write("bad.tum", "0 0 0 0 0 0 0 1\n1 x 0 0 0 0 0 1\n");
  ExpectError(valid + "--ground_truth bad.tum", 1, {"bad.tum, line 2", "'x'"});
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(OfflineTest, RefusesOutputsThatCannotBeWritten) {
  WriteShortRun();
  Write("file", "keep me");
  const std::string recording = ReadFile(Path("run.npz"));
  ExpectError("--input run.npz --output file", 1, {"file: cannot be made a folder", "--output"});
  ExpectError("--input run.npz --output file/out", 1, {"file/out: cannot be made a folder", "--output"});
  ExpectError("--input run.npz --output run.npz", 1, {"run.npz: cannot be made a folder", "--output"});
  // Not even root can make files there.
  ExpectError("--input run.npz --output /proc", 1, {"/proc/trajectory.tum: cannot be written"});
  fs::create_directories(Path("taken/summary.json"));
  ExpectError("--input run.npz --output taken", 1, {"taken/summary.json: cannot be written: it is a folder"});
  EXPECT_EQ(Files("taken"), std::set<std::string>({"summary.json"}));
  EXPECT_EQ(ReadFile(Path("file")), "keep me");
  EXPECT_EQ(ReadFile(Path("run.npz")), recording);
}

TEST_F(OfflineTest, DoesNotOverwriteWhatItReads) {
  WriteShortRun();
  RunWell("--input run.npz --output results");
  const std::string before = Result("results", "trajectory.tum");
  ExpectError("--input run.npz --output results --ground_truth results/trajectory.tum", 1,
              {"results/trajectory.tum: would be overwritten", "--output"});
  fs::rename(Path("run.npz"), Path("results/map.png"));
  ExpectError("--input results/map.png --output ./results/", 1, {"results/map.png: would be overwritten"});
  EXPECT_EQ(Result("results", "trajectory.tum"), before);
  EXPECT_EQ(Files("results"), kResults);
}

TEST_F(OfflineTest, ADiskThatIsFullLeavesNoHalfFiles) {
  WriteShortRun();
  RunWell("--input run.npz --output whole");
  // No file may grow beyond 8 blocks; the signal for it is ignored, so that writing fails as on a full disk.
  const Outcome outcome = Run("--input run.npz --output out", "trap '' XFSZ && ulimit -f 8 &&");
  EXPECT_EQ(outcome.exit_code, 1);
  ExpectOneLine(outcome, {"out/", "could not be written completely"});
  const std::set<std::string> files = Files("out");
  EXPECT_EQ(files.count("map.pgm"), 0u);
  EXPECT_EQ(files.count("summary.json"), 0u);
  EXPECT_EQ(files.count("report.html"), 0u);
  for (const std::string& file : files) EXPECT_TRUE(Result("out", file) == Result("whole", file)) << file;
}

TEST_F(OfflineTest, AnInterruptedRunKeepsWhatItHas) {
  // There and back many times, which takes seconds.
  const Recording once = Record(Orchard(60));
  Recording recording;
  recording.num_beams = once.num_beams;
  for (size_t i = 0; i < 3000; ++i) {
    const size_t phase = i % 118;
    recording.ranges.push_back(once.ranges[phase < 60 ? phase : 118 - phase]);
    recording.stamps.push_back(static_cast<double>(i));
  }
  Write("run.npz", recording.Arrays());
  const std::string input = Path("run.npz").string();
  const std::string output = Path("out").string();
  const std::string errors = Path("errors").string();
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::dup2(::open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
    ::execl(ARBORSLAM_PROGRAM_DIR "/arborslam_offline", "arborslam_offline", "--input", input.c_str(), "--output",
            output.c_str(), "--quiet", static_cast<char*>(nullptr));
    ::_exit(127);
  }
  // It makes the folder right before the first scan.
  for (int i = 0; i < 3000 && !fs::exists(output); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  EXPECT_EQ(::kill(child, SIGINT), 0);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const std::string err = ReadFile(errors);
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_EQ(err.rfind("arborslam_offline: interrupted after ", 0), 0u) << err;
  EXPECT_NE(err.find(output), std::string::npos) << err;
  ASSERT_EQ(Files("out"), kResults);
  const nlohmann::json summary = Summary("out");
  EXPECT_TRUE(summary.at("interrupted").get<bool>());
  const size_t num_read = summary.at("scans").at("read");
  EXPECT_GT(num_read, 0u);
  EXPECT_LT(num_read, 3000u);
  ExpectConsistent(summary, num_read);
  EXPECT_NE(err.find("after " + std::to_string(num_read) + " scans"), std::string::npos) << err;
  // The results are those of a run over just these scans.
  RunWell("--input run.npz --output same --quiet --max_scans " + std::to_string(num_read));
  EXPECT_TRUE(Result("out", "trajectory.tum") == Result("same", "trajectory.tum"));
}

}  // namespace
}  // namespace arborslam
