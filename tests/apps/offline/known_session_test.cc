// Runs arborslam_offline --session with recordings that are new to the session.

#include "apps/offline/known_session.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "backend/store/fingerprint.h"
#include "core/simulation/planar_orchard.h"
#include "tests/apps/walks_test.h"

namespace arborslam {
namespace {

class KnownSessionProgramTest : public WalksProgramTest {
 protected:
  Outcome GoOn(const std::string& session, const std::string& input, const std::string& output,
               const std::string& flags = "") const {
    return RunWell("arborslam_offline",
                   "--session " + session + " --input " + input + " --output " + output + " " + flags);
  }

  void ExpectRefused(const std::string& arguments, int exit_code, const std::vector<std::string>& parts) const {
    ExpectError("arborslam_offline", arguments + " --output refused", exit_code, parts);
    EXPECT_FALSE(fs::exists(Path("refused/session.db"))) << arguments;
    EXPECT_FALSE(fs::exists(Path("refused/recording.db"))) << arguments;
  }

  void ExpectSame(const std::string& a, const std::string& b) const {
    EXPECT_FALSE(ReadFile(Path(a)).empty()) << a;
    EXPECT_TRUE(ReadFile(Path(a)) == ReadFile(Path(b))) << a << ", " << b;
  }

  nlohmann::json Merge(const std::string& output) const {
    return nlohmann::json::parse(ReadFile(Path(output) / "summary.json")).at("merge");
  }

  size_t NumRecordings(const std::string& session) const {
    const std::string info = RunWell("arborslam_session", "info --session " + session).out;
    size_t count = 0;
    for (size_t at = info.find("recording  "); at != std::string::npos; at = info.find("recording  ", at + 1)) ++count;
    return count;
  }

  void ExpectNothingTemporary(const std::string& output) const {
    for (const fs::directory_entry& entry : fs::directory_iterator(Path(output))) {
      const std::string name = entry.path().filename().string();
      EXPECT_EQ(name.find("session.db") == 0, name == "session.db") << name;
      EXPECT_EQ(name.find("recording.db"), std::string::npos) << name;
    }
  }
};

TEST_F(KnownSessionProgramTest, AnotherRecordingComesToWhatMergingGives) {
  Map("there");
  Map("back");
  RunWell("arborslam_session", "merge --session there/session.db back/session.db --output both");
  const std::string before = ReadFile(Path("there/session.db"));
  const std::string out = GoOn("there/session.db", "back.npz", "on", "--threads 1").out;
  for (const char* part : {"back.npz: lies at", "there/session.db", "loops across sessions: "}) {
    EXPECT_NE(out.find(part), std::string::npos) << out;
  }
  ExpectSame("on/trajectory.tum", "both/trajectory_2.tum");
  ExpectSame("on/odometry.tum", "back/odometry.tum");
  for (const char* file : {"graph.g2o", "map.pgm", "map.yaml", "map.png"}) {
    ExpectSame("on/" + std::string(file), "both/" + std::string(file));
  }
  EXPECT_TRUE(ReadFile(Path("there/session.db")) == before);
  EXPECT_EQ(NumRecordings("on/session.db"), 2u);
  RunWell("arborslam_session", "verify --session on/session.db");
  RunWell("arborslam_session", "export --session on/session.db --output exported");
  ExpectSame("exported/trajectory_1.tum", "both/trajectory_1.tum");
  ExpectNothingTemporary("on");
  EXPECT_NE(ReadFile(Path("on/report.html")).find("The map is that of 2 recordings"), std::string::npos);

  const nlohmann::json merge = Merge("on");
  EXPECT_EQ(merge.at("session"), "there/session.db");
  EXPECT_TRUE(merge.at("placed").get<bool>());
  EXPECT_EQ(merge.at("reason"), "");
  EXPECT_GE(merge.at("votes").at("agreeing").get<size_t>(), 5u);
  EXPECT_GE(merge.at("votes").at("recognized").get<size_t>(), merge.at("votes").at("agreeing").get<size_t>());
  EXPECT_GT(merge.at("loops_across").at("accepted").get<size_t>(), 0u);
  EXPECT_GE(merge.at("loops_across").at("tried").get<size_t>(), merge.at("loops_across").at("accepted").get<size_t>());
  // The pose is where the walk began, seen from where the other one did, but for the bend of the two maps.
  const Trajectory3 there = ReadTrajectory(Path("there.tum").string());
  const Trajectory3 back = ReadTrajectory(Path("back.tum").string());
  const SE2 truth = ToPlanar(there).front().pose.Inverse() * ToPlanar(back).front().pose;
  const SE2 placed(merge.at("pose").at("x_m"), merge.at("pose").at("y_m"), merge.at("pose").at("theta_rad"));
  EXPECT_TRUE(AreClose(truth, placed, 0.3, 0.02)) << truth << " " << placed;

  // The same bits for any number of threads, and in place of the session itself.
  GoOn("there/session.db", "back.npz", "there", "--threads 2");
  for (const char* file : {"trajectory.tum", "odometry.tum", "graph.g2o", "map.pgm", "effective_config.yaml"}) {
    ExpectSame("there/" + std::string(file), "on/" + std::string(file));
  }
  EXPECT_EQ(NumRecordings("there/session.db"), 2u);
  ExpectNothingTemporary("there");
}

TEST_F(KnownSessionProgramTest, AThirdRecordingFollowsAndNoneCountsTwice) {
  const PlanarOrchard orchard(Options(2));
  WriteWalk("third", OtherWalk(orchard, 20, 75, 0.1, 9, 5000.0));
  Map("there");
  GoOn("there/session.db", "back.npz", "two");
  GoOn("two/session.db", "third.npz", "three");
  EXPECT_EQ(NumRecordings("three/session.db"), 3u);
  RunWell("arborslam_evaluate",
          "--estimate three/trajectory.tum --reference third.tum --common_alignment --json errors.json");
  EXPECT_LT(nlohmann::json::parse(ReadFile(Path("errors.json"))).at("joint").at("ate_se2_rmse_m").get<double>(), 0.1);
  for (const char* name : {"there.npz", "back.npz", "third.npz"}) {
    ExpectRefused("--session three/session.db --input " + std::string(name), 1,
                  {name, "begins with a scan that the session three/session.db holds already"});
  }
  // Nor a part of one: a walk that begins before it.
  const OtherWalk late(orchard, 20, 75, 0.1, 9, 5000.0);
  OtherWalk extended(orchard, 18, 20, 0.1, 11, 4990.0);
  extended.scans.insert(extended.scans.end(), late.scans.begin(), late.scans.end());
  extended.truth.insert(extended.truth.end(), late.truth.begin(), late.truth.end());
  WriteWalk("extended", extended);
  ExpectRefused("--session three/session.db --input extended.npz", 1,
                {"extended.npz", "scan 4 is in the session three/session.db already"});
}

TEST_F(KnownSessionProgramTest, WithoutACertainPlaceTheResultsAreThoseOfTheRecordingAlone) {
  const PlanarOrchard other(Options(5));
  WriteWalk("other", OtherWalk(other, 0, static_cast<int>(other.NumScans()) - 1, 0.0, 3, 0.0));
  Map("there");
  Map("other");
  const std::string before = ReadFile(Path("there/session.db"));
  ExpectError("arborslam_offline", "--session there/session.db --input other.npz --output on", 1,
              {"other.npz", "no certain place", "there/session.db", "too few agree", "on/session.db"});
  // In the session's own folder it stays, too.
  ExpectError("arborslam_offline", "--session there/session.db --input other.npz --output there", 1,
              {"no certain place", "there/recording.db"});
  EXPECT_TRUE(ReadFile(Path("there/session.db")) == before);
  for (const char* output : {"on", "there"}) {
    for (const char* file : {"trajectory.tum", "odometry.tum", "graph.g2o", "map.pgm", "map.png"}) {
      ExpectSame(std::string(output) + "/" + file, "other/" + std::string(file));
    }
    EXPECT_FALSE(Merge(output).at("placed").get<bool>());
    EXPECT_EQ(Merge(output).at("reason"), "too few agree");
    EXPECT_FALSE(Merge(output).contains("pose"));
  }
  EXPECT_FALSE(fs::exists(Path("on/recording.db")));
  for (const char* session : {"on/session.db", "there/recording.db"}) {
    EXPECT_NE(RunWell("arborslam_session", "info --session " + std::string(session)).out.find("other.npz"),
              std::string::npos);
  }
}

TEST_F(KnownSessionProgramTest, RefusesWhatCannotBePlaced) {
  Map("there", "--max_scans 30");
  const std::string on_there = "--session there/session.db --input back.npz";
  ExpectRefused(on_there + " --odometry_only", 2, {"--odometry_only", "there/session.db"});
  ExpectRefused(on_there + " --set grid.hit_probability=0.6", 2, {"there/session.db", "--set"});
  ExpectRefused(on_there + " --set merge.min_votes=1", 1, {"merge.min_votes"});
  ExpectRefused("--session none.db --input back.npz", 1, {"none.db"});
  ExpectRefused("--session there/map.png --input back.npz", 1, {"there/map.png", "is not a session"});
  // Two recordings of sweeps, to which one of planar scans does not go.
  std::vector<LidarSweep> sweeps;
  const OrchardOptions options;
  const SimulatedRun run(options.run, MakeOrchard(options));
  for (size_t i = 0; i < 10; ++i) sweeps.push_back(run.Sweep(i));
  SessionContents of_sweeps = SessionOf(sweeps, "first");
  of_sweeps.recordings = {{"first", 5, 5}, {"second", 5, of_sweeps.scans.size() - 5}};
  WriteSession(Path("sweeps.db").string(), of_sweeps);
  ExpectRefused("--session sweeps.db --input back.npz", 1,
                {"back.npz: holds planar scans", "sweeps.db", "from sweeps in space"});
  // Not even the session of a recording on its way may be overwritten.
  fs::create_directories(Path("taken"));
  fs::copy_file(Path("there/session.db"), Path("taken/recording.db"));
  ExpectError("arborslam_offline", "--session taken/recording.db --input back.npz --output taken", 1,
              {"taken/recording.db: would be overwritten"});
}

TEST(IsSameScanTest, GoesByStampAndMeasurements) {
  LaserScan scan;
  scan.stamp = 3.0;
  scan.ranges = {1.0f, 2.0f};
  SessionContents::ReadScan read;
  read.result.stamp = 3.0;
  read.fingerprint = FingerprintOf(Scan(scan));
  EXPECT_TRUE(IsSameScan(Scan(scan), read));
  scan.ranges[1] = 2.5f;
  EXPECT_FALSE(IsSameScan(Scan(scan), read));
  // Of old sessions only stamps are known.
  read.fingerprint = 0;
  EXPECT_TRUE(IsSameScan(Scan(scan), read));
  scan.stamp = 4.0;
  EXPECT_FALSE(IsSameScan(Scan(scan), read));
  LidarSweep sweep;
  sweep.start = 2.0;
  sweep.duration = 4.0;
  EXPECT_EQ(StampOf(Scan(sweep)), sweep.Middle());
}

}  // namespace
}  // namespace arborslam
