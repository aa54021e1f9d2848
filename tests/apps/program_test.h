#ifndef ARBORSLAM_TESTS_APPS_PROGRAM_TEST_H_
#define ARBORSLAM_TESTS_APPS_PROGRAM_TEST_H_

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/io/npz.h"
#include "core/simulation/planar_orchard.h"

namespace arborslam {

namespace fs = std::filesystem;

inline std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// How a program ended, and what it said.
struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs programs in a folder of the test's own.
class ProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::path(testing::TempDir()) / ("program_test_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Path(const std::string& name) const { return folder_ / name; }

  void Write(const std::string& name, const std::string& contents) const {
    std::ofstream(Path(name), std::ios::binary) << contents;
  }

  // Runs a program in the test's folder by a shell; `before` goes in front of it.
  Outcome Run(const std::string& program, const std::string& arguments, const std::string& before = "") const {
    const std::string command = "cd '" + folder_.string() + "' && " + before + " '" ARBORSLAM_PROGRAM_DIR "/" +
                                program + "' " + arguments + " >.stdout 2>.stderr";
    const int status = std::system(command.c_str());
    Outcome outcome;
    if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
    outcome.out = ReadFile(Path(".stdout"));
    outcome.err = ReadFile(Path(".stderr"));
    return outcome;
  }

  Outcome RunWell(const std::string& program, const std::string& arguments) const {
    const Outcome outcome = Run(program, arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.err;
    EXPECT_EQ(outcome.err, "") << arguments;
    return outcome;
  }

  // What was said on stderr is one line, the program's error, that holds all `parts`.
  static void ExpectOneLine(const std::string& program, const Outcome& outcome, const std::vector<std::string>& parts) {
    EXPECT_EQ(outcome.err.rfind(program + ": error: ", 0), 0u) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    for (const std::string& part : parts) {
      EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err << "lacks " << part;
    }
  }

  // The program fails with one line on stderr that holds all `parts`.
  Outcome ExpectError(const std::string& program, const std::string& arguments, int exit_code,
                      const std::vector<std::string>& parts, const std::string& before = "") const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run(program, arguments, before);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    ExpectOneLine(program, outcome, parts);
    return outcome;
  }

 private:
  fs::path folder_;
};

/// The same with a recording, `run.npz`, of one walk around an orchard.
class PlanarProgramTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    WriteRecording("run.npz", 5);
  }

  // Once around an orchard; the scan number `silent` has no returns.
  void WriteRecording(const std::string& name, int seed, std::optional<size_t> silent = std::nullopt) const {
    PlanarOrchardOptions options;
    options.seed = seed;
    options.rows = 3;
    options.trees_per_row = 7;
    options.lidar.beams = 449;
    const PlanarOrchard orchard(options);
    NpyArray scans{{orchard.NumScans(), 449}, {}};
    NpyArray stamps{{orchard.NumScans()}, {}};
    for (size_t i = 0; i < orchard.NumScans(); ++i) {
      LaserScan scan = orchard.Scan(i);
      if (i == silent) std::fill(scan.ranges.begin(), scan.ranges.end(), std::numeric_limits<float>::infinity());
      scans.values.insert(scans.values.end(), scan.ranges.begin(), scan.ranges.end());
      stamps.values.push_back(scan.stamp);
    }
    WriteNpz(Path(name).string(), {{"scan0", scans}, {"time", stamps}});
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_APPS_PROGRAM_TEST_H_
