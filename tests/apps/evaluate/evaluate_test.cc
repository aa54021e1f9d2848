// Runs the program itself.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "core/io/npz.h"

namespace arborslam {
namespace {

struct Outcome {
  int exit_code;
  std::string out;
  std::string err;
};

std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class EvaluateTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("evaluate_test_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string Write(const std::string& name, const std::string& contents) {
    std::ofstream(folder_ / name, std::ios::binary) << contents;
    return Path(name);
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  // A loop, moved in the plane by (x, y, yaw), its stamps from `start` on.
  std::string WriteLoop(const std::string& name, double x = 0.0, double y = 0.0, double yaw = 0.0, double start = 0.0,
                        double noise = 0.0) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    std::string text = "# stamp x y z qx qy qz qw\n";
    for (int i = 0; i < 100; ++i) {
      const double t = 0.0628 * i;
      const double px = 10.0 * std::sin(t) + noise * normal(random);
      const double py = 10.0 - 10.0 * std::cos(t) + noise * normal(random);
      char line[256];
      std::snprintf(line, sizeof(line), "%.3f %.9f %.9f 0 0 0 %.9f %.9f\n", start + 0.1 * i,
                    x + std::cos(yaw) * px - std::sin(yaw) * py, y + std::sin(yaw) * px + std::cos(yaw) * py,
                    std::sin(0.5 * (t + yaw)), std::cos(0.5 * (t + yaw)));
      text += line;
    }
    return Write(name, text);
  }

  // A loop in space, its height raised by `lift`, its roll by `roll`.
  std::string WriteLeaningLoop(const std::string& name, double lift, double roll) {
    std::string text;
    for (int i = 0; i < 100; ++i) {
      const double t = 0.0628 * i;
      const Eigen::Quaterniond q = Eigen::AngleAxisd(t, Eigen::Vector3d::UnitZ()) *
                                   Eigen::AngleAxisd(0.1 * std::sin(9.0 * t), Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX());
      char line[256];
      std::snprintf(line, sizeof(line), "%.3f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", 0.1 * i, 10.0 * std::sin(t),
                    10.0 - 10.0 * std::cos(t), std::sin(5.0 * t) + lift * i, q.x(), q.y(), q.z(), q.w());
      text += line;
    }
    return Write(name, text);
  }

  // A map_server map of 6 x 4 cells of 0.5 m from (-1, -1) on, drawn with rows from the top: '#' occupied, '.' free.
  void WriteMap(const std::string& name, const std::string& cells, double origin_x = -1.0, double origin_y = -1.0) {
    std::string pixels;
    for (const char cell : cells) pixels += cell == '#' ? '\x00' : cell == '.' ? '\xfe' : '\xcd';
    Write(name + ".pgm", "P5\n6 4\n255\n" + pixels);
    Write(name + ".yaml", "image: " + name + ".pgm\nresolution: 0.5\norigin: [" + std::to_string(origin_x) + ", " +
                              std::to_string(origin_y) +
                              ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  }

  void WriteSummary(const std::string& name, double median_ms, bool has_errors) {
    nlohmann::json summary = {{"scans", {{"matched", 95}, {"rejected", 5}, {"degenerate", 20}}},
                              {"loops", {{"accepted", 7}}},
                              {"peak_memory_mib", 61.26},
                              {"time_ms", {{"scan_total", {{"median", median_ms}, {"p95", 8.5}}}}}};
    if (has_errors) summary["errors"]["odometry"]["ate_se2_rmse_m"] = 0.039;
    Write(name, summary.dump());
  }

  Outcome Run(const std::string& arguments) const {
    const std::string err_path = Path("stderr.txt");
    const std::string command = std::string("cd '") + folder_.string() +
                                "' && '" ARBORSLAM_PROGRAM_DIR "/arborslam_evaluate' " + arguments + " 2>'" + err_path +
                                "'";
    Outcome outcome{-1, "", ""};
    std::FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) {
      ADD_FAILURE() << "the shell could not be started";
      return outcome;
    }
    char buffer[4096];
    size_t count = 0;
    while ((count = std::fread(buffer, 1, sizeof(buffer), pipe)) > 0) outcome.out.append(buffer, count);
    const int status = ::pclose(pipe);
    if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
    outcome.err = ReadFile(err_path);
    std::filesystem::remove(err_path);
    return outcome;
  }

  // The program fails as it should: its exit code, one line on stderr that holds `part`, nothing on stdout.
  void ExpectError(const std::string& arguments, int exit_code, const std::string& part) const {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.err.rfind("arborslam_evaluate: error: ", 0), 0u) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "") << arguments;
  }

  nlohmann::json RunToJson(const std::string& arguments) const {
    const Outcome outcome = Run(arguments + " --json result.json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return nlohmann::json::parse(ReadFile(Path("result.json")), nullptr, false);
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(EvaluateTest, HelpIsShortAndNamesEveryFlag) {
  const Outcome outcome = Run("--help");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_LT(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 40);
  for (const char* flag : {"--estimate", "--reference", "--align", "--json", "--plot", "--max_time_difference",
                           "--interpolate", "--map", "--map_reference", "--map_tolerance", "--map_beyond_is_unknown",
                           "--summary", "--markdown", "--columns", "--labels", "--help", "--version"}) {
    EXPECT_NE(outcome.out.find(flag), std::string::npos) << flag;
  }
  EXPECT_EQ(outcome.out.find("flagfile"), std::string::npos);
}

TEST_F(EvaluateTest, AMovedCopyHasNoErrorOnceAligned) {
  WriteLoop("reference.tum");
  WriteLoop("estimate.tum", 30.0, -20.0, 2.0);
  for (const char* align : {"", "--align se2", "--align=origin", "--align se3"}) {
    const nlohmann::json json = RunToJson(std::string("--estimate estimate.tum --reference reference.tum ") + align);
    ASSERT_FALSE(json.is_discarded());
    const nlohmann::json& run = json.at("runs").at(0);
    EXPECT_EQ(run.at("matched_poses"), 100);
    EXPECT_LT(run.at("position_rms_m"), 1e-6) << align;
    EXPECT_LT(run.at("heading_rms_rad"), 1e-6) << align;
    EXPECT_LT(run.at("ate_se2_max_m"), 1e-6) << align;
    EXPECT_NEAR(run.at("path_length_m"), 99 * 20.0 * std::sin(0.0314), 1e-6);
  }
  const nlohmann::json json = RunToJson("--estimate estimate.tum --reference reference.tum --align none");
  EXPECT_EQ(json.at("alignment"), "none");
  EXPECT_GT(json.at("runs").at(0).at("position_mean_m"), 20.0);
  EXPECT_NEAR(json.at("runs").at(0).at("heading_mean_rad"), 2.0, 1e-6);
}

TEST_F(EvaluateTest, TheTableSaysTheAlignment) {
  WriteLoop("reference.tum");
  const Outcome se2 = Run("--estimate reference.tum --reference reference.tum");
  EXPECT_EQ(se2.exit_code, 0);
  EXPECT_NE(se2.out.find("SE(2), Umeyama without scale"), std::string::npos) << se2.out;
  EXPECT_NE(se2.out.find("0.0000 rad"), std::string::npos) << se2.out;
  EXPECT_EQ(se2.out.find("-0.0000"), std::string::npos) << se2.out;
  const Outcome origin = Run("--estimate reference.tum --reference reference.tum --align origin");
  EXPECT_NE(origin.out.find("origin (first poses coincide)"), std::string::npos) << origin.out;
}

TEST_F(EvaluateTest, SeveralRunsAreSummarised) {
  WriteLoop("reference.tum");
  WriteLoop("a.tum", 0.0, 0.0, 0.0, 0.0, 0.1);
  WriteLoop("b.tum", 0.0, 0.0, 0.0, 0.0, 0.3);
  const nlohmann::json json = RunToJson("--estimate a.tum b.tum --reference reference.tum --plot plot.png");
  const double a = json.at("runs").at(0).at("ate_se2_rmse_m");
  const double b = json.at("runs").at(1).at("ate_se2_rmse_m");
  EXPECT_NEAR(a, 0.1 * std::sqrt(2.0), 0.03);
  const nlohmann::json& summary = json.at("summary").at("ate_se2_rmse_m");
  EXPECT_EQ(summary.at("runs"), 2);
  EXPECT_NEAR(summary.at("mean"), 0.5 * (a + b), 1e-12);
  // For two runs sd / sqrt(2) is half their difference.
  EXPECT_NEAR(summary.at("half_width_95"), 1.96 * 0.5 * std::abs(a - b), 1e-12);
  EXPECT_TRUE(std::filesystem::exists(Path("plot_1.png")));
  EXPECT_TRUE(std::filesystem::exists(Path("plot_2.png")));
  EXPECT_FALSE(std::filesystem::exists(Path("plot.png")));
  const Outcome table = Run("--estimate a.tum --estimate=b.tum --reference reference.tum b.tum");
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("b.tum against b.tum"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("\n+- "), std::string::npos) << table.out;
}

TEST_F(EvaluateTest, RollPitchAndHeightWhereBothHaveThem) {
  WriteLeaningLoop("reference.tum", 0.0, 0.0);
  WriteLeaningLoop("estimate.tum", 0.01, 0.02);
  const nlohmann::json run = RunToJson("--estimate estimate.tum --reference reference.tum").at("runs").at(0);
  EXPECT_NEAR(run.at("roll_rms_rad"), 0.02, 1e-6);
  EXPECT_LT(run.at("pitch_rms_rad"), 1e-6);
  // A ramp of 0.01 m a pose less its mean.
  EXPECT_NEAR(run.at("z_offset_m"), -0.01 * 49.5, 1e-6);
  EXPECT_NEAR(run.at("z_rms_m"), 0.01 * std::sqrt((100.0 * 100.0 - 1.0) / 12.0), 1e-6);
  EXPECT_NEAR(run.at("position_3d_rms_m"), run.at("z_rms_m"), 1e-6);
  WriteLoop("planar.tum");
  const nlohmann::json planar = RunToJson("--estimate planar.tum --reference reference.tum").at("runs").at(0);
  for (const char* key : {"roll_rms_rad", "pitch_rms_rad", "z_rms_m", "position_3d_rms_m"}) {
    EXPECT_TRUE(planar.at(key).is_null()) << key;
  }
}

TEST_F(EvaluateTest, MapsAloneAreComparedAsTheyLie) {
  WriteMap("truth", "##.........#......##....");
  WriteMap("map", "#..........#.....#......");
  const nlohmann::json json = RunToJson("--map map.yaml --map_reference truth.yaml");
  EXPECT_EQ(json.at("map_tolerance_m"), 0.0);
  const nlohmann::json& run = json.at("runs").at(0);
  EXPECT_FALSE(run.contains("estimate"));
  EXPECT_FALSE(run.contains("position_rms_m"));
  EXPECT_DOUBLE_EQ(run.at("map_precision"), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(run.at("map_sensitivity"), 2.0 / 5.0);
  EXPECT_DOUBLE_EQ(run.at("map_accuracy"), 20.0 / 24.0);
  EXPECT_EQ(run.at("map").at("true_negative_cells"), 18);
  EXPECT_EQ(run.at("map").at("false_negative_cells"), 3);
  const nlohmann::json near =
      RunToJson("--map map.yaml --map_reference truth.yaml --map_tolerance 0.5").at("runs").at(0);
  EXPECT_DOUBLE_EQ(near.at("map_precision"), 1.0);
  EXPECT_DOUBLE_EQ(near.at("map_sensitivity"), 3.0 / 5.0);
  const Outcome table = Run("--map map.yaml --map_reference truth.yaml --map_tolerance 0.5");
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("map precision"), std::string::npos) << table.out;
  EXPECT_NE(table.out.find("3 of its 5 found"), std::string::npos) << table.out;
  EXPECT_EQ(table.out.find("estimate  "), std::string::npos) << table.out;
}

TEST_F(EvaluateTest, AMapIsMovedAsItsTrajectoryIs) {
  WriteLoop("reference.tum");
  WriteMap("truth", "##.........#......##....");
  // The estimate's frame is the reference's, moved by (-2, 3): so are its map and its trajectory.
  WriteLoop("estimate.tum", 2.0, -3.0);
  WriteMap("map", "##.........#......##....", 1.0, -4.0);
  const std::string arguments =
      "--estimate estimate.tum --reference reference.tum --map map.yaml --map_reference truth.yaml ";
  for (const char* align : {"se2", "se3", "origin"}) {
    const nlohmann::json run = RunToJson(arguments + "--align " + align).at("runs").at(0);
    EXPECT_DOUBLE_EQ(run.at("map_precision"), 1.0) << align;
    EXPECT_DOUBLE_EQ(run.at("map_sensitivity"), 1.0) << align;
    EXPECT_DOUBLE_EQ(run.at("map_accuracy"), 1.0) << align;
    EXPECT_NEAR(run.at("map").at("T_reference_map").at(1), 3.0, 1e-6) << align;
    EXPECT_LT(run.at("position_rms_m"), 1e-6) << align;
  }
  const nlohmann::json run = RunToJson(arguments + "--align none").at("runs").at(0);
  EXPECT_LT(run.at("map_sensitivity"), 0.5);
  EXPECT_GT(run.at("map").at("outside_cells"), 0);
  EXPECT_EQ(run.at("map").at("unjudged_cells"), 0);
  const nlohmann::json open = RunToJson(arguments + "--align none --map_beyond_is_unknown");
  EXPECT_EQ(open.at("map_beyond_is_unknown"), true);
  EXPECT_EQ(open.at("runs").at(0).at("map").at("unjudged_cells"), run.at("map").at("outside_cells"));
}

TEST_F(EvaluateTest, SeveralMapsAndSummariesMakeOneTable) {
  WriteLoop("a.tum");
  WriteMap("truth", "##.........#......##....");
  WriteMap("poor", "#......................#");
  WriteSummary("1.json", 2.0, true);
  WriteSummary("2.json", 3.0, false);
  const std::string arguments =
      "--estimate a.tum a.tum --reference a.tum --map truth.yaml poor.yaml --map_reference truth.yaml "
      "--summary 1.json 2.json --labels 'seed 1' 'seed|2' ";
  const nlohmann::json json = RunToJson(arguments);
  EXPECT_EQ(json.at("runs").at(1).at("label"), "seed|2");
  EXPECT_DOUBLE_EQ(json.at("summary").at("map_precision").at("mean"), 0.75);
  EXPECT_DOUBLE_EQ(json.at("summary").at("scan_time_median_ms").at("mean"), 2.5);
  EXPECT_DOUBLE_EQ(json.at("runs").at(0).at("rejected_percent"), 5.0);
  EXPECT_DOUBLE_EQ(json.at("runs").at(0).at("degenerate_percent"), 20.0);
  EXPECT_EQ(json.at("summary").at("odometry_ate_se2_rmse_m").at("runs"), 1);
  EXPECT_TRUE(json.at("runs").at(1).at("odometry_ate_se2_rmse_m").is_null());
  const Outcome table = Run(arguments);
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("m_prec"), std::string::npos) << table.out;
  EXPECT_EQ(table.out.find("RMS_z "), std::string::npos) << "no run has heights\n" << table.out;

  const std::string columns =
      "--columns map_precision odometry_ate_se2_rmse_m scan_time_median_ms loops_accepted z_rms_m ";
  EXPECT_EQ(Run(arguments + columns + "--markdown table.md").exit_code, 0);
  EXPECT_EQ(ReadFile(Path("table.md")),
            "| run | m_prec | odo_ATE [m] | t_med [ms] | loops | RMS_z [m] |\n"
            "|---|---:|---:|---:|---:|---:|\n"
            "| seed 1 | 1.0000 | 0.0390 | 2.00 | 7 | - |\n"
            "| seed\\|2 | 0.5000 | - | 3.00 | 7 | - |\n"
            "| mean | 0.7500 ± 0.4900 | 0.0390 | 2.50 ± 0.98 | 7 ± 0 | - |\n");
  EXPECT_EQ(Run("--map poor.yaml --map_reference truth.yaml --columns map_sensitivity --markdown one.md")
                .out.find("map precision"),
            std::string::npos);
  EXPECT_EQ(ReadFile(Path("one.md")), "| run | m_sens |\n|---|---:|\n| 1 | 0.2000 |\n");
}

TEST_F(EvaluateTest, MapsAndSummariesThatCannotBeUsed) {
  WriteLoop("a.tum");
  WriteMap("a", "##......................");
  WriteMap("empty", "........................");
  Write("no.json", "{\"scans\": 3}");
  Write("noise.json", "PK???");
  const std::string maps = "--map a.yaml --map_reference a.yaml ";
  ExpectError("--map a.yaml", 2, "--map_reference FILE is missing");
  ExpectError("--map_reference a.yaml", 2, "--map FILE is missing");
  ExpectError("--reference a.tum " + maps, 2, "--estimate FILE is missing");
  ExpectError("--map a.yaml a.yaml a.yaml --map_reference a.yaml a.yaml", 2, "2 files for 3 of --map");
  ExpectError("--estimate a.tum a.tum --reference a.tum " + maps, 2, "--map has 1 values for 2 runs");
  ExpectError(maps + "--labels a b", 2, "--labels has 2 values for 1 runs");
  ExpectError(maps + "--summary a b", 2, "--summary has 2 values for 1 runs");
  ExpectError(maps + "--plot x.png", 2, "--plot draws trajectories");
  ExpectError(maps + "--columns ate", 2, "'ate', which is none of: path_length_m, position_mean_m");
  ExpectError(maps + "--map_tolerance -1", 2, "--map_tolerance is -1.0");
  ExpectError(maps + "--map_tolerance nan", 2, "must be 0 m or more");
  ExpectError(maps + "--map_tolerance 100", 1, "a.yaml against a.yaml: the tolerance is 100");
  ExpectError("--map a.yaml --map_reference empty.yaml", 1, "the reference map has no occupied cell");
  ExpectError("--map missing.yaml --map_reference a.yaml", 1, "missing.yaml");
  ExpectError("--map a.tum --map_reference a.yaml", 1, "a.tum");
  ExpectError(maps + "--summary noise.json", 1, "noise.json: is not JSON");
  ExpectError(maps + "--summary no.json", 1, "no.json: has no number at /scans/matched");
  ExpectError(maps + "--markdown a.yaml", 2, "would be written over the file of --map");
  ExpectError(maps + "--markdown x --json x", 2, "choose two names");
  const nlohmann::json run = RunToJson("--map empty.yaml --map_reference a.yaml").at("runs").at(0);
  EXPECT_TRUE(run.at("map_precision").is_null());
  EXPECT_EQ(run.at("map_sensitivity"), 0.0);
}

TEST_F(EvaluateTest, InterpolatesAcrossGapsWhenAsked) {
  WriteLoop("reference.tum");
  WriteLoop("between.tum", 0.0, 0.0, 0.0, 0.04);
  ExpectError("--estimate between.tum --reference reference.tum", 1, "no stamps match within 0.02 s");
  const nlohmann::json json = RunToJson("--estimate between.tum --reference reference.tum --interpolate 0.15");
  EXPECT_EQ(json.at("runs").at(0).at("matched_poses"), 99);
  EXPECT_EQ(RunToJson("--estimate between.tum --reference reference.tum --max_time_difference 0.05")
                .at("runs")
                .at(0)
                .at("matched_poses"),
            100);
}

TEST_F(EvaluateTest, RelationsAloneAndWithAReference) {
  Write("a.tum", "1 0 0 0 0 0 0 1\n2 1.3 0 0 0 0 0 1\n3 2.4 0 0 0 0 0 1\n");
  Write("a.relations", "1 2 1 0 0 0 0 0\n2 3 1 0 0 0 0 0\n8 9 1 0 0 0 0 0\n");
  const Outcome alone = Run("--estimate a.tum --relations a.relations --json result.json");
  EXPECT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_NE(alone.out.find("2 of 3 relations"), std::string::npos) << alone.out;
  const nlohmann::json json = nlohmann::json::parse(std::ifstream(Path("result.json")));
  EXPECT_NEAR(json["runs"][0]["relations_translation_mean_m"].get<double>(), 0.2, 1e-9);
  EXPECT_NEAR(json["runs"][0]["relations_translation_sd_m"].get<double>(), 0.1, 1e-9);
  EXPECT_NEAR(json["runs"][0]["relations_rotation_mean_deg"].get<double>(), 0.0, 1e-9);
  EXPECT_EQ(json["runs"][0]["relations"]["matched_relations"], 2);
  EXPECT_EQ(json["runs"][0]["relations"]["unmatched_relations"], 1);
  const Outcome both =
      Run("--estimate a.tum --reference a.tum --relations a.relations --columns "
          "relations_translation_max_m ate_se2_rmse_m");
  EXPECT_EQ(both.exit_code, 0) << both.err;
  EXPECT_NE(both.out.find("0.3000 m"), std::string::npos) << both.out;
  const Outcome two = Run("--estimate a.tum a.tum --relations a.relations");
  EXPECT_NE(two.out.find("rel_t"), std::string::npos) << two.out;
  ExpectError("--relations a.relations", 2, "--estimate FILE is missing");
  ExpectError("--estimate a.tum a.tum --relations a.relations a.relations a.relations", 2, "3 files for 2");
  ExpectError("--estimate a.tum --relations missing.relations", 1, "does not exist");
  ExpectError("--estimate a.tum --relations a.relations --json a.relations", 2, "written over the file of --relations");
}

TEST_F(EvaluateTest, CommandLinesThatCannotBeUsed) {
  WriteLoop("a.tum");
  ExpectError("", 2, "--estimate FILE is missing");
  ExpectError("--estimate a.tum", 2, "--reference FILE is missing");
  ExpectError("--estimate", 2, "--estimate needs at least one value");
  ExpectError("--estimate a.tum a.tum a.tum --reference a.tum a.tum", 2, "2 files for 3");
  ExpectError("a.tum", 2, "'a.tum' belongs to no flag");
  ExpectError("--estimate a.tum --reference a.tum --algin se2", 2, "the nearest is --align");
  ExpectError("--estimate a.tum --reference a.tum --align sim3", 2, "'sim3'");
  ExpectError("--estimate a.tum --reference a.tum --align", 2, "--align needs a value");
  ExpectError("--estimate a.tum --reference a.tum --max_time_difference soon", 2, "must be a number");
  ExpectError("--estimate a.tum --reference a.tum --max_time_difference nan", 2, "must be 0 s or more");
  ExpectError("--estimate a.tum --reference a.tum --interpolate -1", 2, "must be 0 s or more");
  ExpectError("--estimate a.tum --reference a.tum --json x --plot x", 2, "choose two names");
}

TEST_F(EvaluateTest, NeverWritesOverItsInput) {
  WriteLoop("a.tum");
  const std::string before = ReadFile(Path("a.tum"));
  ExpectError("--estimate a.tum --reference a.tum --json ./a.tum", 2, "would be written over");
  ExpectError("--estimate a.tum --reference a.tum --plot a.tum", 2, "would be written over");
  EXPECT_EQ(ReadFile(Path("a.tum")), before);
}

TEST_F(EvaluateTest, LeavesNothingBehindWhenItFails) {
  WriteLoop("a.tum");
  WriteLoop("late.tum", 0.0, 0.0, 0.0, 1e6);
  ExpectError("--estimate a.tum late.tum --reference a.tum --json x.json --plot x.png", 1,
              "late.tum against a.tum: no stamps match");
  ExpectError("--estimate a.tum --reference a.tum --json none/x.json", 1, "none/x.json");
  ExpectError("--estimate a.tum --reference a.tum --plot none/x.png", 1, "none/x.png");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(Path("")), std::filesystem::directory_iterator()), 2);
}

TEST_F(EvaluateTest, FilesThatAreNoTrajectories) {
  WriteLoop("good.tum");
  std::mt19937 random(3);
  std::string noise(5000, '\0');
  for (char& byte : noise) byte = static_cast<char>(random());
  Write("noise.tum", noise);
  Write("noise.npz", "PK\x03\x04" + noise);
  Write("empty.tum", "");
  Write("comment.tum", "# nothing\n");
  Write("short.tum", "1 2 3\n");
  Write("words.tum", "1 2 3 four 0 0 0 1\n");
  Write("nan.tum", "1 nan 3 4 0 0 0 1\n");
  Write("huge.tum", "0 1e300 3 4 0 0 0 1\n");
  Write("null.tum", "1 2 3 4 0 0 0 0\n");
  Write("json.tum", "{\"a\": 1}\n");
  std::filesystem::create_directory(Path("folder.tum"));
  for (const char* name : {"noise.tum", "noise.npz", "empty.tum", "comment.tum", "short.tum", "words.tum", "nan.tum",
                           "huge.tum", "null.tum", "json.tum", "folder.tum", "missing.tum"}) {
    ExpectError(std::string("--estimate ") + name + " --reference good.tum", 1, name);
    ExpectError(std::string("--estimate good.tum --reference ") + name, 1, name);
  }
}

TEST_F(EvaluateTest, OnePoseIsEnough) {
  Write("one.tum", "1 2 3 4 0 0 0 1\n");
  const nlohmann::json json = RunToJson("--estimate one.tum --reference one.tum --plot one.png");
  const nlohmann::json& run = json.at("runs").at(0);
  EXPECT_EQ(run.at("position_rms_m"), 0.0);
  EXPECT_TRUE(run.at("step_length_mean_m").is_null());
  EXPECT_TRUE(run.at("position_percent").is_null());
  EXPECT_TRUE(json.at("summary").at("position_percent").is_null());
  EXPECT_TRUE(std::filesystem::exists(Path("one.png")));
}

TEST_F(EvaluateTest, AFullDiskUnderStdoutIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  WriteLoop("a.tum");
  const Outcome outcome = Run("--estimate a.tum --reference a.tum >/dev/full");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("standard output"), std::string::npos);
}

TEST_F(EvaluateTest, PullallyReferenceHasPositionsOnly) {
  const char* data = std::getenv("ARBORSLAM_DATA");
  const std::string path =
      std::string(data != nullptr ? data : ARBORSLAM_SOURCE_DIR "/../shared/data") + "/pullally/p_v2_d1.npz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there; set ARBORSLAM_DATA";
  const nlohmann::json json = RunToJson("--estimate '" + path + "' --reference '" + path + "' --align origin");
  const nlohmann::json& run = json.at("runs").at(0);
  EXPECT_EQ(run.at("matched_poses"), 546);
  EXPECT_NEAR(run.at("path_length_m"), 151.0, 0.5);
  EXPECT_LT(run.at("position_rms_m"), 1e-9);
  EXPECT_TRUE(run.at("heading_mean_rad").is_null());
}

TEST_F(EvaluateTest, OneAlignmentOfAllRuns) {
  // The references lie 0.1 m ahead of the estimates and 0.1 m behind, in the frame of a site.
  for (const char* name : {"a.tum", "b.tum"}) Write(name, "0 -1 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n");
  const auto write_reference = [this](const std::string& name, double shift) {
    WriteNpz(Path(name), {{"gnss_rotated_c", {{2, 2}, {0, 0, 2, 0}}},
                          {"gnss_data", {{2, 3}, {500 + shift, 7000, 9, 502 + shift, 7000, 9}}}});
  };
  write_reference("a.npz", 0.1);
  write_reference("b.npz", -0.1);
  const std::string files = "--estimate a.tum b.tum --reference a.npz b.npz --json out.json";
  const Outcome together = Run(files + " --common_alignment");
  ASSERT_EQ(together.exit_code, 0) << together.err;
  EXPECT_NE(together.out.find("one for all runs"), std::string::npos) << together.out;
  EXPECT_NE(together.out.find("joint: 4 pairs"), std::string::npos) << together.out;
  EXPECT_NE(together.out.find("RMSE 0.1000 m"), std::string::npos) << together.out;
  auto json = nlohmann::json::parse(ReadFile(Path("out.json")));
  EXPECT_EQ(json.at("common_alignment"), true);
  EXPECT_EQ(json.at("joint").at("matched_poses"), 4);
  EXPECT_NEAR(json.at("joint").at("ate_se2_rmse_m").get<double>(), 0.1, 1e-9);
  for (const auto& run : json.at("runs")) {
    EXPECT_NEAR(run.at("position_rms_m").get<double>(), 0.1, 1e-9);
    EXPECT_NEAR(run.at("T_reference_estimate")[0][3].get<double>(), 501.0, 1e-9);
    EXPECT_NEAR(run.at("T_reference_estimate")[1][3].get<double>(), 7000.0, 1e-9);
  }
  // Each by itself fits.
  const Outcome apart = Run(files);
  ASSERT_EQ(apart.exit_code, 0) << apart.err;
  json = nlohmann::json::parse(ReadFile(Path("out.json")));
  EXPECT_EQ(json.at("common_alignment"), false);
  EXPECT_EQ(json.count("joint"), 0u);
  EXPECT_NEAR(json.at("runs")[1].at("ate_se2_rmse_m").get<double>(), 0.0, 1e-9);
  WriteMap("map", "##....\n......\n......\n......");
  EXPECT_EQ(Run("--map map.yaml --map_reference map.yaml --common_alignment").exit_code, 2);
}

}  // namespace
}  // namespace arborslam
