// Runs arborslam_offline and arborslam_session: interrupted runs, and what is made of their sessions.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "core/io/npz.h"
#include "core/simulation/planar_orchard.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

std::string ReadFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Outcome {
  int exit_code = -1;
  std::string out;
  std::string err;
};

class SessionProgramTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) /
              ("session_program_test_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    WriteRecording("run.npz", 5);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Path(const std::string& name) const { return folder_ / name; }

  // Once around an orchard.
  void WriteRecording(const std::string& name, int seed) const {
    PlanarOrchardOptions options;
    options.seed = seed;
    options.rows = 3;
    options.trees_per_row = 7;
    options.lidar.beams = 449;
    const PlanarOrchard orchard(options);
    NpyArray scans{{orchard.NumScans(), 449}, {}};
    NpyArray stamps{{orchard.NumScans()}, {}};
    for (size_t i = 0; i < orchard.NumScans(); ++i) {
      const LaserScan scan = orchard.Scan(i);
      scans.values.insert(scans.values.end(), scan.ranges.begin(), scan.ranges.end());
      stamps.values.push_back(scan.stamp);
    }
    WriteNpz(Path(name).string(), {{"scan0", scans}, {"time", stamps}});
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

  // The program fails with one line on stderr that holds all `parts`.
  void ExpectError(const std::string& program, const std::string& arguments, int exit_code,
                   const std::vector<std::string>& parts, const std::string& before = "") const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run(program, arguments, before);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_EQ(outcome.err.rfind(program + ": error: ", 0), 0u) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    for (const std::string& part : parts) {
      EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err << "lacks " << part;
    }
  }

  // Starts arborslam_offline and kills it after `milliseconds`, or lets it end before that.
  void KillAfter(int milliseconds, const std::string& output) const {
    const std::string input = Path("run.npz").string();
    const std::string folder = Path(output).string();
    const pid_t child = ::fork();
    if (child == 0) {
      const int nowhere = ::open("/dev/null", O_WRONLY);
      ::dup2(nowhere, 1);
      ::dup2(nowhere, 2);
      ::execl(ARBORSLAM_PROGRAM_DIR "/arborslam_offline", "arborslam_offline", "--input", input.c_str(), "--output",
              folder.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    ASSERT_GT(child, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
  }

  void ExpectSameResults(const std::string& a, const std::string& b) const {
    for (const char* file : {"trajectory.tum", "odometry.tum", "graph.g2o", "map.pgm", "map.yaml", "map.png"}) {
      EXPECT_FALSE(ReadFile(Path(a) / file).empty()) << file;
      EXPECT_TRUE(ReadFile(Path(a) / file) == ReadFile(Path(b) / file)) << file;
    }
  }

 private:
  fs::path folder_;
};

TEST_F(SessionProgramTest, AKilledRunGoesOnToTheSameResults) {
  const auto begin = std::chrono::steady_clock::now();
  RunWell("arborslam_offline", "--input run.npz --output whole");
  const auto duration = std::chrono::steady_clock::now() - begin;
  const auto milliseconds = static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(duration).count());
  std::mt19937 random(7);
  int num_resumed = 0;
  for (int i = 0; i < 5; ++i) {
    SCOPED_TRACE(i);
    fs::remove_all(Path("out"));
    KillAfter(std::uniform_int_distribution<int>(1, milliseconds)(random), "out");
    if (!fs::exists(Path("out/session.db"))) continue;
    ++num_resumed;
    RunWell("arborslam_session", "info --session out/session.db");
    RunWell("arborslam_offline", "--session out/session.db --input run.npz --output out");
    ExpectSameResults("out", "whole");
    RunWell("arborslam_session", "verify --session out/session.db");
  }
  EXPECT_GT(num_resumed, 0);
}

TEST_F(SessionProgramTest, ARunThatWasStoppedGoesOnInAnotherFolder) {
  RunWell("arborslam_offline", "--input run.npz --output whole");
  RunWell("arborslam_offline", "--input run.npz --output part --max_scans 40");
  const std::string before = ReadFile(Path("part/session.db"));
  RunWell("arborslam_offline", "--session part/session.db --input run.npz --output out");
  ExpectSameResults("out", "whole");
  EXPECT_TRUE(ReadFile(Path("part/session.db")) == before);
  EXPECT_TRUE(ReadFile(Path("out/effective_config.yaml")) == ReadFile(Path("whole/effective_config.yaml")));
}

TEST_F(SessionProgramTest, TellsWhyItDoesNotGoOn) {
  WriteRecording("other.npz", 6);
  RunWell("arborslam_offline", "--input run.npz --output part --max_scans 40");
  ExpectError("arborslam_offline", "--session part/session.db --input other.npz --output out", 1,
              {"other.npz", "scan 1 is not the one", "part/session.db"});
  EXPECT_FALSE(fs::exists(Path("out/session.db")));
  ExpectError("arborslam_offline",
              "--session part/session.db --input run.npz --output out --set tracker.rebuild_interval=3", 2,
              {"part/session.db", "--set"});
  ExpectError("arborslam_offline", "--session none.db --input run.npz --output out", 1, {"none.db"});
  ExpectError("arborslam_offline", "--session part/map.png --input run.npz --output out", 1,
              {"part/map.png", "is not a session"});
  // What only the end of the run reads may be another one.
  RunWell("arborslam_offline", "--session part/session.db --input run.npz --output out --set map.resolution=0.1");
}

TEST_F(SessionProgramTest, KeepsWhatItHasWhenTheDiskIsFull) {
  RunWell("arborslam_offline", "--input run.npz --output whole");
  // A limit on file sizes (blocks of 512 bytes) stands in for a full disk.
  ExpectError("arborslam_offline", "--input run.npz --output out", 1, {"out/session.db"}, "ulimit -f 500 &&");
  EXPECT_FALSE(fs::exists(Path("out/trajectory.tum")));
  RunWell("arborslam_offline", "--session out/session.db --input run.npz --output out");
  ExpectSameResults("out", "whole");
}

TEST_F(SessionProgramTest, ExportsWithoutTheRecording) {
  RunWell("arborslam_offline", "--input run.npz --output whole");
  fs::remove(Path("run.npz"));
  RunWell("arborslam_session", "export --session whole/session.db --output exported");
  for (const char* file : {"trajectory.tum", "graph.g2o", "map.pgm", "map.yaml", "map.png"}) {
    EXPECT_TRUE(ReadFile(Path("exported") / file) == ReadFile(Path("whole") / file)) << file;
  }
  const std::string info = RunWell("arborslam_session", "info --session whole/session.db").out;
  for (const char* part : {"whole/session.db", "run.npz", "finished", "keyframes"}) {
    EXPECT_NE(info.find(part), std::string::npos) << info;
  }
  EXPECT_NE(RunWell("arborslam_session", "verify --session whole/session.db").out.find("whole, "), std::string::npos);
  EXPECT_NE(RunWell("arborslam_session", "migrate --session whole/session.db").out.find("present format"),
            std::string::npos);
}

TEST_F(SessionProgramTest, SaysWhatIsWrongWithTheCommandLine) {
  ExpectError("arborslam_session", "", 2, {"the command is missing", "verify"});
  ExpectError("arborslam_session", "verfy --session a.db", 2, {"did you mean 'verify'"});
  ExpectError("arborslam_session", "info", 2, {"--session FILE.db is missing"});
  ExpectError("arborslam_session", "export --session a.db", 2, {"--output DIR is missing"});
  ExpectError("arborslam_session", "info --session a.db --output b", 2, {"--output"});
  ExpectError("arborslam_session", "info --session none.db", 1, {"none.db"});
  EXPECT_NE(RunWell("arborslam_session", "--help").out.find("export --session"), std::string::npos);
}

TEST_F(SessionProgramTest, VerifyFindsDamage) {
  RunWell("arborslam_offline", "--input run.npz --output whole");
  std::string bytes = ReadFile(Path("whole/session.db"));
  bytes.resize(bytes.size() / 2);
  std::ofstream(Path("cut.db"), std::ios::binary) << bytes;
  ExpectError("arborslam_session", "verify --session cut.db", 1, {"cut.db", "is damaged"});
}

}  // namespace
}  // namespace arborslam
