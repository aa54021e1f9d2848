#include "core/io/sweep_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/kitti_bin.h"
#include "core/io/scan_source.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A sweep of one point, told from others by its x.
LidarSweep SweepAt(float x) {
  LidarSweep sweep;
  sweep.points = {{x, 2.0f, 3.0f}};
  return sweep;
}

std::vector<LidarSweep> ReadAll(ScanSource* source) {
  std::vector<LidarSweep> sweeps;
  while (const std::optional<Scan> scan = source->Next()) sweeps.push_back(std::get<LidarSweep>(*scan));
  return sweeps;
}

TEST(SweepFolder, GivesTheSweepsOfAFolderWithStampsBesideIt) {
  const TempFolder folder;
  std::filesystem::create_directories(folder.File("run/clouds"));
  for (const char* name : {"9", "10", "8"}) {
    WriteKittiBin(folder.File("run/clouds/" + std::string(name) + ".bin"), SweepAt(std::stof(name)));
  }
  folder.Write("run/timestamps.txt", "100.0\n100.1\n100.2\n");
  for (const char* input : {"run", "run/", "run/clouds", "run/clouds/"}) {
    const std::unique_ptr<ScanSource> source = OpenScanSource(folder.File(input));
    EXPECT_EQ(source->NumScans(), 3u);
    const std::vector<LidarSweep> sweeps = ReadAll(source.get());
    ASSERT_EQ(sweeps.size(), 3u);
    EXPECT_EQ(sweeps[0].points[0].x(), 8.0f);
    EXPECT_EQ(sweeps[1].points[0].x(), 9.0f);
    EXPECT_EQ(sweeps[2].points[0].x(), 10.0f);
    EXPECT_EQ(sweeps[2].start, 100.2);
    EXPECT_NEAR(sweeps[2].duration, 0.1, 1e-9);
  }
}

}  // namespace
}  // namespace arborslam
