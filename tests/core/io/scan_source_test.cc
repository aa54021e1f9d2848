#include "core/io/scan_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "core/io/kitti_bin.h"
#include "core/io/npz.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(OpenScanSource, SaysWhyAPathIsNoRecording) {
  const TempFolder folder;
  const auto error = [](const std::string& path) { return UserErrorOf([&] { OpenScanSource(path); }); };
  EXPECT_THAT(error(folder.File("missing.npz")), AllOf(HasSubstr("missing.npz"), HasSubstr("does not exist")));
  EXPECT_THAT(error(folder.path()), AllOf(HasSubstr("is a folder"), HasSubstr("is empty"), HasSubstr(".npz")));
  EXPECT_THAT(error(folder.Write("empty.npz", "")), HasSubstr("is empty"));
  EXPECT_THAT(error(folder.Write("noise.npz", std::string(1000, '\x7f'))),
              AllOf(HasSubstr("no known format"), HasSubstr(".npz")));
  EXPECT_THAT(error(folder.Write("cut.npz", "PK\3\4")), HasSubstr("damaged or incomplete"));
  WriteNpz(folder.File("other.npz"), {{"x", {{1}, {1}}}});
  EXPECT_THAT(error(folder.File("other.npz")), AllOf(HasSubstr("without scans"), HasSubstr("'x'")));
}

TEST(OpenScanSource, GoesByContentAndNotByName) {
  const TempFolder folder;
  WriteNpz(folder.File("recording.dat"), {{"scan0", {{1, 2}, {1, 1}}}});
  EXPECT_EQ(OpenScanSource(folder.File("recording.dat"))->NumScans(), 1u);
}

TEST(OpenScanSource, SaysWhatAFolderWithoutRecordingHolds) {
  const TempFolder folder;
  folder.Write("a.bag", "x");
  folder.Write("b.bag", "x");
  folder.Write("notes", "x");
  std::filesystem::create_directory(folder.File("images"));
  std::filesystem::create_directory(folder.File("clouds"));
  EXPECT_THAT(UserErrorOf([&] { OpenScanSource(folder.path()); }),
              AllOf(HasSubstr("it holds 2 .bag, 2 folders, 1 files without an extension"), HasSubstr("*.pcd"),
                    HasSubstr("timestamps.txt"), HasSubstr(".npz")));
}

TEST(OpenScanSource, HandsItsOptionsToFoldersOfSweeps) {
  const TempFolder folder;
  LidarSweep sweep;
  sweep.points = {{1, 2, 3}};
  WriteKittiBin(folder.File("1.bin"), sweep);
  folder.Write("timestamps.txt", "8\n");
  const std::unique_ptr<ScanSource> source = OpenScanSource(folder.path(), {"end", 0.5});
  EXPECT_EQ(source->NumScans(), 1u);
  EXPECT_EQ(std::get<LidarSweep>(*source->Next()).start, 7.5);
}

}  // namespace
}  // namespace arborslam
