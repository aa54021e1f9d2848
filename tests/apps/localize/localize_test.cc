// Runs arborslam_localize in the session of a simulated run.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/io/trajectory_io.h"
#include "tests/apps/program_test.h"

namespace arborslam {
namespace {

class LocalizeProgramTest : public PlanarProgramTest {
 protected:
  void MakeMap() const { RunWell("arborslam_offline", "--input run.npz --output map"); }
};

TEST_F(LocalizeProgramTest, FindsARecordingInItsOwnMapAndLeavesTheMapAlone) {
  MakeMap();
  const std::string before = ReadFile(Path("map/session.db"));
  ASSERT_FALSE(before.empty());
  RunWell("arborslam_localize", "--session map/session.db --input run.npz --output located");
  EXPECT_TRUE(ReadFile(Path("map/session.db")) == before);

  const auto summary = nlohmann::json::parse(ReadFile(Path("located/summary.json")));
  EXPECT_FALSE(summary.empty());
  const Trajectory3 map = ReadTrajectory(Path("map/trajectory.tum").string());
  const Trajectory3 located = ReadTrajectory(Path("located/trajectory.tum").string());
  ASSERT_GT(located.poses.size(), map.poses.size() * 9 / 10);
  // Stamps of both are those of the scans.
  size_t compared = 0;
  size_t wrong = 0;
  for (const StampedPose3& pose : located.poses) {
    for (const StampedPose3& truth : map.poses) {
      if (truth.stamp != pose.stamp) continue;
      ++compared;
      wrong += (truth.position - pose.position).norm() > 0.2 ? 1 : 0;
    }
  }
  EXPECT_EQ(compared, located.poses.size());
  EXPECT_LE(wrong, compared / 50);
}

TEST_F(LocalizeProgramTest, AnInitialPoseLocatesTheFirstScan) {
  MakeMap();
  RunWell("arborslam_localize",
          "--session map/session.db --input run.npz --output located --initial_pose 0.2,-0.2,0.05 --max_scans 5");
  EXPECT_EQ(ReadTrajectory(Path("located/trajectory.tum").string()).poses.size(), 5u);
}

TEST_F(LocalizeProgramTest, WrongInputIsSaidInOneLine) {
  ExpectError("arborslam_localize", "--input run.npz --output out", 2, {"--session"});
  ExpectError("arborslam_localize", "--session none.db --input run.npz --output out", 1, {"none.db"});
  ExpectError("arborslam_localize", "--session run.npz --input run.npz --output out", 1, {"run.npz"});
  ExpectError("arborslam_localize", "--session none.db --input run.npz --output out --initial_pose 1,2", 2,
              {"--initial_pose", "1,2"});
  EXPECT_FALSE(std::filesystem::exists(Path("out/trajectory.tum")));
}

}  // namespace
}  // namespace arborslam
