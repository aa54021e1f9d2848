#include "apps/common/output_folder.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/error.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

TEST(OutputFolder, IsMadeWithThoseAboveItAndLeftEmpty) {
  const TempFolder temp;
  const std::string path = temp.File("a/b");
  EXPECT_EQ(PrepareOutputFolder(path, {"one.txt", "two.txt"}, {"", temp.File("none")}), path);
  EXPECT_TRUE(std::filesystem::is_empty(path));
}

TEST(OutputFolder, AFileIsNoFolder) {
  const TempFolder temp;
  temp.Write("file", "text");
  EXPECT_THROW(MakeOutputFolder(temp.File("file")), UserError);
  EXPECT_THROW(MakeOutputFolder(temp.File("file/out")), UserError);
}

TEST(OutputFolder, NoInputIsOverwritten) {
  const TempFolder temp;
  temp.Write("one.txt", "text");
  EXPECT_THROW(PrepareOutputFolder(temp.File(""), {"one.txt"}, {temp.File("one.txt")}), UserError);
  EXPECT_NO_THROW(PrepareOutputFolder(temp.File(""), {"two.txt"}, {temp.File("one.txt")}));
  EXPECT_TRUE(std::filesystem::exists(temp.File("one.txt")));
  EXPECT_FALSE(std::filesystem::exists(temp.File("two.txt")));
}

}  // namespace
}  // namespace arborslam
