#include "core/io/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::HasSubstr;

TEST(InputFile, OpensAtTheBeginning) {
  const TempFolder folder;
  std::ifstream stream = OpenInputFile(folder.Write("a", "xyz"));
  EXPECT_EQ(stream.get(), 'x');
}

TEST(InputFile, EachKindOfUnreadablePathHasItsOwnSentence) {
  const TempFolder folder;
  const auto error = [](const std::string& path) { return UserErrorOf([&] { OpenInputFile(path); }); };
  EXPECT_THAT(error(folder.File("missing")), HasSubstr("missing: does not exist"));
  EXPECT_THAT(error(""), HasSubstr("does not exist"));
  EXPECT_THAT(error(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(error("/dev/zero"), HasSubstr("is not a regular file"));
  EXPECT_THAT(error(folder.Write("empty", "")), HasSubstr("is empty"));
  EXPECT_THAT(error(folder.Write("file", "x") + "/below"), HasSubstr("cannot be read: Not a directory"));
}

TEST(InputFile, ZipArchivesAreToldByTheirFirstBytes) {
  const TempFolder folder;
  EXPECT_TRUE(HasZipMagic(folder.Write("a", "PK\3\4...")));
  EXPECT_TRUE(HasZipMagic(folder.Write("a", "PK\5\6...")));
  EXPECT_FALSE(HasZipMagic(folder.Write("a", "PK\3")));
  EXPECT_FALSE(HasZipMagic(folder.Write("a", "PK\3\6")));
  EXPECT_FALSE(HasZipMagic(folder.Write("a", "PNG\4")));
}

TEST(Quoted, IsOneReadableLine) {
  EXPECT_EQ(Quoted("scan0"), "'scan0'");
  EXPECT_EQ(Quoted("a\nb\x1b[31m\xff"), "'a?b?[31m?'");
  EXPECT_EQ(Quoted(std::string(40, 'x')), "'" + std::string(40, 'x') + "'");
  EXPECT_EQ(Quoted(std::string(1000, 'x')), "'" + std::string(40, 'x') + "...'");
}

}  // namespace
}  // namespace arborslam
