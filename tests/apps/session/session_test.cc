// Runs arborslam_offline and arborslam_session: interrupted runs, and what is made of their sessions.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/apps/program_test.h"

namespace arborslam {
namespace {

class SessionProgramTest : public PlanarProgramTest {
 protected:
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
              "--session part/session.db --input run.npz --output out --set tracker.rebuild_distance=3", 2,
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
