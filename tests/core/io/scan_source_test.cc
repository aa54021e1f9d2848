#include "core/io/scan_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

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
  EXPECT_THAT(error(folder.path()), AllOf(HasSubstr("is a folder"), HasSubstr(".npz")));
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

}  // namespace
}  // namespace arborslam
