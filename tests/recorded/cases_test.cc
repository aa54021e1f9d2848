// Small recordings with one fault each, on which a run was once wrong without a word.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <variant>

#include "backend/run_verdict.h"
#include "backend/slam.h"
#include "backend/store/session_reader.h"
#include "core/error.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/g2o.h"
#include "core/io/map_io.h"
#include "core/io/scan_source.h"
#include "core/io/trajectory_io.h"
#include "frontend/mounting/levelled_source.h"

namespace arborslam {
namespace {

using testing::HasSubstr;

std::string CasePath(const std::string& name) {
  const char* folder = std::getenv("ARBORSLAM_DATA");
  return (std::filesystem::path(folder != nullptr ? folder : ARBORSLAM_SOURCE_DIR "/../shared/data") / "cases" / name)
      .string();
}

struct Outcome {
  std::vector<ScanResult> scans;
  FinishResult finish;
  RunVerdict verdict;
  Trajectory3 trajectory;
  std::string notices;

  size_t NumMeasured() const {
    return static_cast<size_t>(
        std::count(finish.pose_sources.begin(), finish.pose_sources.end(), PoseSource::kMeasured));
  }
};

Outcome RunCase(const std::string& path) {
  Outcome outcome;
  const std::unique_ptr<ScanSource> source = OpenLevelledSource(path);
  for (const std::string& notice : source->Notices()) outcome.notices += notice + "\n";
  Slam slam(SlamOptions(), 1);
  while (const std::optional<Scan> scan = source->Next()) {
    outcome.scans.push_back(std::visit([&slam](const auto& any) { return slam.AddScan(any); }, *scan));
  }
  outcome.finish = slam.Finish(false);
  std::vector<size_t> indices(outcome.finish.pose_sources.size());
  std::iota(indices.begin(), indices.end(), size_t{0});
  outcome.verdict = JudgeRun(outcome.finish.pose_sources, outcome.finish.segments, indices);
  outcome.trajectory = slam.OptimizedTrajectory3();
  return outcome;
}

struct Case {
  const char* path;
  size_t num_scans;
  size_t min_measured;
  const char* notice;        // That the reader must give; "": none is asked for.
  const char* ground_truth;  // "": none.
  double max_ate;            // [m]
};

class CaseTest : public testing::TestWithParam<Case> {};

TEST_P(CaseTest, IsRight) {
  const Case& expected = GetParam();
  const std::string path = CasePath(expected.path);
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; set ARBORSLAM_DATA";
  const Outcome outcome = RunCase(path);
  EXPECT_EQ(outcome.scans.size(), expected.num_scans);
  EXPECT_GE(outcome.NumMeasured(), expected.min_measured);
  EXPECT_THAT(outcome.notices, HasSubstr(expected.notice));
  if (expected.ground_truth[0] == '\0') return;
  const AssociationResult pairs = Associate(outcome.trajectory, ReadTrajectory(CasePath(expected.ground_truth)),
                                            AssociationOptions{}, expected.path);
  EXPECT_LE(EvaluateTrajectory(pairs.pairs, pairs.has_headings, AlignmentKind::kSe2).metrics.ate_rmse,
            expected.max_ate);
}

INSTANTIATE_TEST_SUITE_P(Inputs, CaseTest,
                         testing::Values(Case{"bin_5_floats/s", 12, 12, "5 x float32", "bin_5_floats/gt.tum", 0.06},
                                         Case{"bin_float64/s", 12, 12, "4 x float64", "bin_float64/gt.tum", 0.06},
                                         Case{"carmen_nan/nan.clf", 60, 60, "", "", 0.0},
                                         Case{"first_scan_incomplete/first_half_blocked.npz", 60, 59, "", "", 0.0},
                                         Case{"names_secs_nsecs_unpadded/s", 16, 16, "", "", 0.0},
                                         Case{"npz_time_ns/ns.npz", 60, 60, "nanoseconds", "", 0.0},
                                         Case{"one_damaged_sweep/s", 16, 15, "", "one_damaged_sweep/gt.tum", 0.06},
                                         Case{"one_damaged_sweep/e", 16, 15, "", "one_damaged_sweep/gt.tum", 0.06},
                                         Case{"one_wrong_time_first_sweep/bad", 30, 30, "nanoseconds",
                                              "one_wrong_time_first_sweep/gt.tum", 0.05},
                                         Case{"one_zero_time/zero", 10, 10, "for seconds", "one_zero_time/gt.tum",
                                              0.05},
                                         Case{"ply_trailing_blank/ply_space.ply", 1, 1, "", "", 0.0},
                                         Case{"stamps_backwards_npz/back.npz", 60, 60, "set back", "", 0.0},
                                         Case{"stamps_backwards_npz/zero.npz", 60, 60, "do not tell", "", 0.0},
                                         Case{"stamps_backwards_npz/f32.npz", 60, 60, "no scan is lost", "", 0.0},
                                         Case{"stamps_gps_rollover/s", 16, 16, "set back", "", 0.0},
                                         Case{"stamps_relative_ns/s", 16, 16, "nanoseconds", "", 0.0},
                                         Case{"faults/stamps_1e-160.npz", 6, 6, "do not tell", "", 0.0},
                                         Case{"faults/npz_aborts.npz", 120, 110, "do not tell", "", 0.0}),
                         [](const testing::TestParamInfo<Case>& one) {
                           std::string name = one.param.path;
                           std::replace_if(
                               name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

TEST(CasesTest, AnIncompleteFirstScanChangesNothing) {
  const std::string whole = CasePath("first_scan_incomplete/npz_base.npz");
  const std::string half = CasePath("first_scan_incomplete/first_half_blocked.npz");
  if (!std::filesystem::exists(whole)) GTEST_SKIP() << whole << " is not here; set ARBORSLAM_DATA";
  const Outcome expected = RunCase(whole);
  const Outcome outcome = RunCase(half);
  EXPECT_EQ(outcome.verdict.state, RunState::kOk) << TextOf(outcome.verdict);
  const auto to_last = [](const Trajectory3& trajectory) {
    const StampedPose3& second = trajectory.poses[1];
    return (trajectory.poses.back().position - second.position).norm();
  };
  EXPECT_NEAR(to_last(outcome.trajectory), to_last(expected.trajectory), 0.3);
}

TEST(CasesTest, NoiseIsLost) {
  for (const char* name : {"faults/noise.npz", "faults/empty90.npz", "faults/shuffle.npz"}) {
    const std::string path = CasePath(name);
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here; set ARBORSLAM_DATA";
    EXPECT_EQ(RunCase(path).verdict.state, RunState::kLost) << name;
  }
}

TEST(CasesTest, ReadersSayWhatIsBeyondThem) {
  const std::string keys = CasePath("gtsam_keys/gtsam_keys.g2o");
  if (!std::filesystem::exists(keys)) GTEST_SKIP() << keys << " is not here; set ARBORSLAM_DATA";
  try {
    ReadG2o(keys);
    FAIL() << "ids of 64 bits fit into 32";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("beyond what is supported"));
  }
  for (const char* name : {"map_unknown_key/map_type.yaml", "map_unknown_key/x_extra_newline.yaml"}) {
    EXPECT_GT(ReadMapServer(CasePath(name)).width, 0) << name;
  }
  EXPECT_THROW(ReadSession(CasePath("faults/verify_ok_export_aborts.db")), UserError);
}

}  // namespace
}  // namespace arborslam
