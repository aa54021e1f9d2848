#include "core/io/kitti_bin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>

#include "core/io/sweep_points.h"
#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(ReadKittiBin, GivesThePointsInOrderAndCountsThoseThatAreNone) {
  const TempFolder folder;
  const std::string path = folder.Write(
      "a.bin",
      RawValues<float>({1, 2, 3, 0.5f, 0, 0, 0, 9, kNaN, 1, 1, 1, 4, kInf, 1, 1, 1, 1, -kInf, 1, 0, 0, -5, kNaN}));
  const LidarSweep sweep = ReadKittiBin(path);
  EXPECT_THAT(sweep.points, ElementsAre(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(0, 0, -5)));
  EXPECT_EQ(sweep.num_dropped, 4u);
  EXPECT_THAT(sweep.times, IsEmpty());
}

TEST(ReadKittiBin, AFileOfNoBytesIsASweepWithoutPoints) {
  const TempFolder folder;
  EXPECT_THAT(ReadKittiBin(folder.Write("a.bin", "")).points, IsEmpty());
}

TEST(ReadKittiBin, RefusesWhatIsNoWholeNumberOfPointsOrNoSweep) {
  const TempFolder folder;
  const auto error = [](const std::string& path) { return UserErrorOf([&] { ReadKittiBin(path); }); };
  EXPECT_THAT(error(folder.Write("cut.bin", std::string(100, '\1'))),
              AllOf(HasSubstr("cut.bin"), HasSubstr("100 bytes")));
  EXPECT_THAT(error(folder.File("none.bin")), HasSubstr("does not exist"));
  EXPECT_THAT(error(folder.path()), HasSubstr("is a folder"));
  folder.Write("huge.bin", "");
  std::filesystem::resize_file(folder.File("huge.bin"), 16 * (kMaxSweepPoints + 1));  // Sparse: takes no room.
  EXPECT_THAT(error(folder.File("huge.bin")), HasSubstr("16777217 points"));
}

TEST(WriteKittiBin, IsReadBackAsItWas) {
  const TempFolder folder;
  LidarSweep sweep;
  for (int i = 0; i < 10000; ++i) {
    sweep.points.emplace_back(static_cast<float>(i) / 3.0f, -static_cast<float>(i), 1e-30f);
  }
  WriteKittiBin(folder.File("a.bin"), sweep);
  EXPECT_EQ(std::filesystem::file_size(folder.File("a.bin")), 160000u);
  EXPECT_EQ(ReadKittiBin(folder.File("a.bin")).points, sweep.points);
  WriteKittiBin(folder.File("b.bin"), LidarSweep());
  EXPECT_THAT(ReadKittiBin(folder.File("b.bin")).points, IsEmpty());
}

}  // namespace
}  // namespace arborslam
