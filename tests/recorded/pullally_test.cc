// Bounds on the real orchard. Its GNSS positions are a reference here and never an input.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "backend/slam.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/scan_source.h"
#include "core/io/trajectory_io.h"

namespace arborslam {
namespace {

struct Recording {
  std::vector<LaserScan> scans;
  Trajectory3 reference;
};

struct Outcome {
  TrajectoryMetrics trajectory;
  TrajectoryMetrics odometry;
  double rejected_share = 0.0;
  size_t num_matched_poses = 0;
};

class PullallyTest : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("ARBORSLAM_DATA");
    const std::filesystem::path path =
        std::filesystem::path(folder != nullptr ? folder : ARBORSLAM_SOURCE_DIR "/../shared/data") / "pullally" /
        (std::string(GetParam()) + ".npz");
    if (!std::filesystem::exists(path)) {
      GTEST_SKIP() << path << " is not here; set ARBORSLAM_DATA to the folder of the recorded data";
    }
    const std::unique_ptr<ScanSource> source = OpenScanSource(path.string());
    while (const std::optional<Scan> scan = source->Next()) recording_.scans.push_back(std::get<LaserScan>(*scan));
    recording_.reference = ReadTrajectory(path.string());
    ASSERT_EQ(recording_.scans.size(), recording_.reference.poses.size());
  }

  static Outcome Run(const Recording& recording) {
    Slam slam(SlamOptions(), 2);
    Trajectory odometry;
    size_t num_rejected = 0;
    for (const LaserScan& scan : recording.scans) {
      const ScanResult result = slam.AddScan(scan);
      num_rejected += result.status == ScanStatus::kPredicted ? 1 : 0;
      if (result.status != ScanStatus::kSkipped) odometry.push_back({result.stamp, result.T_odom_base});
    }
    slam.Finish(false);
    Outcome outcome;
    const auto evaluate = [&](const Trajectory& estimate) {
      const AssociationResult pairs =
          Associate(ToTrajectory3(estimate), recording.reference, AssociationOptions(), "the recording");
      outcome.num_matched_poses = pairs.pairs.size();
      return EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2).metrics;
    };
    outcome.odometry = evaluate(odometry);
    outcome.trajectory = evaluate(slam.OptimizedTrajectory());
    outcome.rejected_share = static_cast<double>(num_rejected) / static_cast<double>(recording.scans.size());
    RecordProperty("trajectory_ate_rmse_m", std::to_string(outcome.trajectory.ate_rmse));
    RecordProperty("odometry_ate_rmse_m", std::to_string(outcome.odometry.ate_rmse));
    RecordProperty("end_error_m", std::to_string(outcome.trajectory.end_error));
    RecordProperty("rejected_share", std::to_string(outcome.rejected_share));
    return outcome;
  }

  // The ATE [m] over what is left when about every tenth scan is left out, drawn by `seed`.
  double ErrorWithoutATenth(unsigned seed) const {
    std::mt19937 random(seed);
    Recording thinned;
    thinned.reference.has_orientation = false;
    for (size_t i = 0; i < recording_.scans.size(); ++i) {
      if (random() % 10 == 0) continue;
      thinned.scans.push_back(recording_.scans[i]);
      thinned.reference.poses.push_back(recording_.reference.poses[i]);
    }
    return Run(thinned).trajectory.ate_rmse;
  }

  Recording recording_;
};

TEST_P(PullallyTest, TrajectoryAndOdometryWithDefaultOptions) {
  const Outcome outcome = Run(recording_);
  EXPECT_EQ(outcome.num_matched_poses, recording_.scans.size());
  EXPECT_LE(outcome.trajectory.ate_rmse, 0.05);
  EXPECT_LE(outcome.trajectory.end_error, 0.10);
  EXPECT_LE(outcome.odometry.ate_rmse, 0.10);
  EXPECT_LE(outcome.rejected_share, 0.05);
}

// Which scans are left out matters: of 32 draws one or two lose the run for a while, where several scans in a row are
// missing at a headland. So the middle one of three counts.
TEST_P(PullallyTest, WithATenthOfTheScansLeftOut) {
  std::array<double, 3> errors;
  for (unsigned seed = 1; seed <= 3; ++seed) errors[seed - 1] = ErrorWithoutATenth(seed);
  std::sort(errors.begin(), errors.end());
  EXPECT_LE(errors[1], 0.08);
}

TEST_P(PullallyTest, BackwardsInTime) {
  Recording reversed;
  reversed.reference.has_orientation = false;
  for (size_t i = recording_.scans.size(); i-- > 0;) {
    reversed.scans.push_back(recording_.scans[i]);
    reversed.scans.back().stamp *= -1.0;
    reversed.reference.poses.push_back(recording_.reference.poses[i]);
    reversed.reference.poses.back().stamp *= -1.0;
  }
  EXPECT_LE(Run(reversed).trajectory.ate_rmse, 0.08);
}

INSTANTIATE_TEST_SUITE_P(Runs, PullallyTest, testing::Values("p_v2_d1", "p_v2_d2"),
                         [](const testing::TestParamInfo<const char*>& run) { return std::string(run.param); });

}  // namespace
}  // namespace arborslam
