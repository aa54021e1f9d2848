#ifndef ARBORSLAM_TESTS_APPS_WALKS_TEST_H_
#define ARBORSLAM_TESTS_APPS_WALKS_TEST_H_

#include <string>
#include <vector>

#include "backend/store/session_writer.h"
#include "core/io/npz.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/orchard.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/simulated_run.h"
#include "tests/apps/program_test.h"
#include "tests/backend/session_of_run.h"

namespace arborslam {

/// Runs programs on two walks through one orchard, there.npz and back.npz.
class WalksProgramTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const PlanarOrchard orchard(Options(2));
    const auto last = static_cast<int>(orchard.NumScans()) - 1;
    WriteWalk("there", OtherWalk(orchard, 0, last, 0.0, 3, 100.0));
    // Stamps that overlap with those of the other walk are no problem.
    WriteWalk("back", OtherWalk(orchard, last * 3 / 4, 0, 0.1, 7, 50.0));
  }

  static PlanarOrchardOptions Options(int seed) {
    PlanarOrchardOptions options;
    options.seed = seed;
    options.rows = 3;
    options.trees_per_row = 9;
    return options;
  }

  // A walk as a recording, and where it really went, in the frame of the orchard.
  void WriteWalk(const std::string& name, const OtherWalk& walk) const {
    NpyArray scans{{walk.scans.size(), walk.scans.front().ranges.size()}, {}};
    NpyArray stamps{{walk.scans.size()}, {}};
    Trajectory truth;
    for (size_t i = 0; i < walk.scans.size(); ++i) {
      const LaserScan& scan = walk.scans[i];
      scans.values.insert(scans.values.end(), scan.ranges.begin(), scan.ranges.end());
      stamps.values.push_back(scan.stamp);
      truth.push_back({scan.stamp, walk.truth[i]});
    }
    WriteNpz(Path(name + ".npz").string(), {{"scan0", scans}, {"time", stamps}});
    WriteTum(Path(name + ".tum").string(), truth);
  }

  // The session of a few sweeps in space.
  void SimulatedSweeps(const std::string& name) const {
    const OrchardOptions options;
    const SimulatedRun run(options.run, MakeOrchard(options));
    std::vector<LidarSweep> sweeps;
    for (size_t i = 0; i < 10; ++i) sweeps.push_back(run.Sweep(i));
    WriteSession(Path(name).string(), SessionOf(sweeps, "sweeps"));
  }

  void Map(const std::string& name, const std::string& flags = "") const {
    RunWell("arborslam_offline", "--input " + name + ".npz --output " + name + " " + flags);
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_APPS_WALKS_TEST_H_
