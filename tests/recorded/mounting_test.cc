// Small recordings whose ground is not where it usually is: a lidar upside down, points in the robot's frame, ghosts.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/slam.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/scan_source.h"
#include "core/io/trajectory_io.h"
#include "frontend/mounting/levelled_source.h"

namespace arborslam {
namespace {

class MountingCasesTest : public testing::Test {
 protected:
  struct Outcome {
    size_t num_scans = 0;
    size_t num_matched = 0;
    Trajectory3 trajectory;  // T_map_lidar of the upright frame.
    std::string notices;
  };

  // Of tests' data, or "" where it is absent.
  static std::string Folder(const std::string& name) {
    const char* folder = std::getenv("ARBORSLAM_DATA");
    const std::filesystem::path path =
        std::filesystem::path(folder != nullptr ? folder : ARBORSLAM_SOURCE_DIR "/../shared/data") / "cases" / name;
    return std::filesystem::exists(path) ? path.string() : "";
  }

  static Outcome Run(const std::string& path) {
    Outcome outcome;
    const std::unique_ptr<ScanSource> source = OpenLevelledSource(path);
    for (const std::string& notice : source->Notices()) outcome.notices += notice + "\n";
    Slam slam(SlamOptions(), 1);
    while (const std::optional<Scan> scan = source->Next()) {
      const ScanResult result = slam.AddScan(std::get<LidarSweep>(*scan));
      ++outcome.num_scans;
      outcome.num_matched += result.status == ScanStatus::kMatched ? 1 : 0;
    }
    slam.Finish(false);
    outcome.trajectory = slam.OptimizedTrajectory3();
    return outcome;
  }

  static double Ate(const Outcome& outcome, const std::string& ground_truth) {
    const AssociationResult pairs =
        Associate(outcome.trajectory, ReadTrajectory(ground_truth), AssociationOptions{}, ground_truth);
    return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2).metrics.ate_rmse;
  }
};

TEST_F(MountingCasesTest, UpsideDownIsNotMirrored) {
  const std::string folder = Folder("upside_down");
  if (folder.empty()) GTEST_SKIP() << "case upside_down is absent; set ARBORSLAM_DATA";
  const Outcome outcome = Run(folder + "/s");
  EXPECT_NE(outcome.notices.find("upside down (roll 180 deg"), std::string::npos) << outcome.notices;
  EXPECT_GE(outcome.num_matched, 17u);
  // A mirrored path would not fit: 0.13 m and more.
  EXPECT_LE(Ate(outcome, folder + "/gt.tum"), 0.06);
}

TEST_F(MountingCasesTest, PointsInTheRobotsFrameWorkLikeTheLidars) {
  const std::string folder = Folder("base_link_frame");
  if (folder.empty()) GTEST_SKIP() << "case base_link_frame is absent; set ARBORSLAM_DATA";
  const Outcome control = Run(folder + "/lidar");
  const Outcome outcome = Run(folder + "/s");
  EXPECT_EQ(control.notices.find("base_link"), std::string::npos) << control.notices;
  EXPECT_NE(outcome.notices.find("base_link"), std::string::npos) << outcome.notices;
  EXPECT_EQ(control.num_matched, 16u);
  EXPECT_EQ(outcome.num_matched, 16u);
  ASSERT_EQ(outcome.trajectory.poses.size(), control.trajectory.poses.size());
  for (size_t i = 0; i < control.trajectory.poses.size(); ++i) {
    // Of every third column only, matches are loose: what differs by rounding differs by a decimetre in the end.
    EXPECT_LT((outcome.trajectory.poses[i].position - control.trajectory.poses[i].position).norm(), 0.3) << i;
  }
}

TEST_F(MountingCasesTest, GhostsBelowTheGroundDoNotHideIt) {
  const std::string folder = Folder("ghosts_below_ground");
  if (folder.empty()) GTEST_SKIP() << "case ghosts_below_ground is absent; set ARBORSLAM_DATA";
  const Outcome outcome = Run(folder + "/s");
  EXPECT_EQ(outcome.num_scans, 20u);
  EXPECT_EQ(outcome.num_matched, 20u);
  EXPECT_LE(Ate(outcome, folder + "/gt.tum"), 0.06);
}

}  // namespace
}  // namespace arborslam
