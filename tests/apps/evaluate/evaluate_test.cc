// Runs the program itself.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

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
                           "--interpolate", "--help", "--version"}) {
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

}  // namespace
}  // namespace arborslam
