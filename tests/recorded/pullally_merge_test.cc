// Two real walks through one orchard in one map, both ways around. The GNSS positions, in the frame of the site, are a
// reference here and never an input.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "backend/merge/session_merger.h"
#include "backend/run_outputs.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/scan_source.h"
#include "core/io/trajectory_io.h"
#include "tests/backend/session_of_run.h"

namespace arborslam {
namespace {

TEST(PullallyMergeTest, TwoWalksLieInOneMap) {
  const char* data = std::getenv("ARBORSLAM_DATA");
  const std::filesystem::path folder =
      std::filesystem::path(data != nullptr ? data : ARBORSLAM_SOURCE_DIR "/../shared/data") / "pullally";
  std::vector<SessionContents> sessions;
  std::vector<Trajectory3> references;
  for (const char* name : {"p_v2_d1.npz", "p_v2_d2.npz"}) {
    const std::string path = (folder / name).string();
    if (!std::filesystem::exists(path)) {
      GTEST_SKIP() << path << " is not here; set ARBORSLAM_DATA to the folder of the recorded data";
    }
    const std::unique_ptr<ScanSource> source = OpenScanSource(path);
    std::vector<LaserScan> scans;
    while (const std::optional<Scan> scan = source->Next()) scans.push_back(std::get<LaserScan>(*scan));
    sessions.push_back(SessionOf(scans, name));
    references.push_back(ReadTrajectory(path, ReferenceFrame::kOfSite));
  }
  for (const size_t first : {size_t{0}, size_t{1}}) {
    SCOPED_TRACE(first);
    SessionMerger merger(SlamOptions(), MergeOptions(), 2, sessions[first]);
    const PlaceVotes votes = merger.Add(sessions[1 - first]);
    ASSERT_EQ(votes.reason, "");
    EXPECT_GE(votes.agreeing.size(), votes.num_asked / 2);
    EXPECT_EQ(votes.num_rivals, 0u);
    merger.Finish();
    const Trajectory3 all = Trajectory3Of(merger.merged().graph, merger.merged().scans);
    std::vector<RunPairs> runs;
    auto begin = all.poses.begin();
    for (const size_t which : {first, 1 - first}) {
      Trajectory3 estimate;
      const auto end = begin + static_cast<std::ptrdiff_t>(sessions[which].scans.size());
      estimate.poses.assign(begin, end);
      begin = end;
      const AssociationResult pairs = Associate(estimate, references[which], AssociationOptions(), "the recording");
      EXPECT_EQ(pairs.unmatched_reference, 0u);
      runs.push_back({pairs.pairs, pairs.has_headings});
    }
    const JointEvaluation joint = EvaluateTogether(runs, AlignmentKind::kSe2);
    EXPECT_LE(joint.ate_rmse, 0.05);
    for (const TrajectoryEvaluation& run : joint.runs) EXPECT_LE(run.metrics.ate_rmse, 0.05);
    RecordProperty("joint_ate_rmse_m_" + std::to_string(first), std::to_string(joint.ate_rmse));
  }
}

}  // namespace
}  // namespace arborslam
