// arborslam_offline goes on in the map of one real walk with another one. The GNSS positions, in the frame of the site,
// are a reference here and never an input.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "backend/run_outputs.h"
#include "backend/store/session_reader.h"
#include "core/evaluation/association.h"
#include "core/evaluation/trajectory_metrics.h"
#include "core/io/trajectory_io.h"
#include "tests/apps/program_test.h"

namespace arborslam {
namespace {

class PullallyGoingOnTest : public ProgramTest {};

TEST_F(PullallyGoingOnTest, ASecondWalkLiesInTheMapOfTheFirst) {
  const char* data = std::getenv("ARBORSLAM_DATA");
  const fs::path folder = fs::path(data != nullptr ? data : ARBORSLAM_SOURCE_DIR "/../shared/data") / "pullally";
  std::vector<Trajectory3> references;
  for (const char* name : {"p_v2_d1.npz", "p_v2_d2.npz"}) {
    const fs::path path = folder / name;
    if (!fs::exists(path)) {
      GTEST_SKIP() << path << " is not here; set ARBORSLAM_DATA to the folder of the recorded data";
    }
    fs::copy_file(path, Path(name));
    references.push_back(ReadTrajectory(path.string(), ReferenceFrame::kOfSite));
  }
  RunWell("arborslam_offline", "--input p_v2_d1.npz --output first --threads 2");
  RunWell("arborslam_offline", "--session first/session.db --input p_v2_d2.npz --output both --threads 2");
  std::vector<Trajectory3> estimates = TrajectoriesOf(ReadSession(Path("both/session.db").string()));
  ASSERT_EQ(estimates.size(), 2u);
  estimates[1] = ReadTrajectory(Path("both/trajectory.tum").string());
  std::vector<RunPairs> runs;
  for (size_t i = 0; i < 2; ++i) {
    const AssociationResult pairs = Associate(estimates[i], references[i], AssociationOptions(), "the recording");
    EXPECT_EQ(pairs.unmatched_reference, 0u);
    runs.push_back({pairs.pairs, pairs.has_headings});
  }
  const JointEvaluation joint = EvaluateTogether(runs, AlignmentKind::kSe2);
  EXPECT_LE(joint.ate_rmse, 0.07);
  RecordProperty("joint_ate_rmse_m", std::to_string(joint.ate_rmse));
}

}  // namespace
}  // namespace arborslam
