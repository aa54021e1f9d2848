#include "core/io/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(AtomicFile, AppearsOnlyWhenCommitted) {
  const TempFolder folder;
  const std::string path = folder.File("out.txt");
  AtomicFile file(path);
  file.stream() << "whole";
  EXPECT_FALSE(std::filesystem::exists(path));
  file.Commit(AtomicFile::Durability::kSynced);
  EXPECT_EQ(ReadWhole(path), "whole");
  EXPECT_THAT(folder.Names(), ElementsAre("out.txt"));
}

TEST(AtomicFile, LeavesTheOldFileAndNoTemporaryWhenAbandoned) {
  const TempFolder folder;
  const std::string path = folder.Write("out.txt", "old");
  EXPECT_THROW(
      {
        AtomicFile file(path);
        file.stream() << "half" << std::flush;
        throw std::logic_error("interrupted");
      },
      std::logic_error);
  EXPECT_EQ(ReadWhole(path), "old");
  EXPECT_THAT(folder.Names(), ElementsAre("out.txt"));
}

TEST(AtomicFile, ReplacesAnOldFile) {
  const TempFolder folder;
  const std::string path = folder.Write("out.txt", "a much longer old text");
  WriteFileAtomically(path, "new");
  EXPECT_EQ(ReadWhole(path), "new");
}

TEST(AtomicFile, KeepsEveryByte) {
  const TempFolder folder;
  std::string contents;
  for (uint32_t i = 0; i < 300000; ++i) contents.push_back(static_cast<char>(i * 7919 >> 3));
  WriteFileAtomically(folder.File("blob"), contents);
  EXPECT_EQ(ReadWhole(folder.File("blob")), contents);
  WriteFileAtomically(folder.File("empty"), "");
  EXPECT_TRUE(std::filesystem::exists(folder.File("empty")));
  EXPECT_EQ(ReadWhole(folder.File("empty")), "");
}

TEST(AtomicFile, FilesHaveTheUsualPermissions) {
  const TempFolder folder;
  folder.Write("usual", "");
  WriteFileAtomically(folder.File("ours"), "");
  const auto permissions = [&](const char* name) { return std::filesystem::status(folder.File(name)).permissions(); };
  EXPECT_EQ(permissions("ours"), permissions("usual"));
}

TEST(AtomicFile, TwoAtOnceDoNotCollide) {
  const TempFolder folder;
  AtomicFile a(folder.File("a"));
  AtomicFile b(folder.File("b"));
  a.stream() << "A";
  b.stream() << "B";
  a.Commit();
  b.Commit();
  EXPECT_EQ(ReadWhole(folder.File("a")), "A");
  EXPECT_EQ(ReadWhole(folder.File("b")), "B");
}

TEST(AtomicFile, NamesFileAndReasonWhenTheFolderCannotHoldIt) {
  const TempFolder folder;
  const std::string below_a_file = folder.Write("file", "") + "/x";
  EXPECT_THAT(UserErrorOf([&] { AtomicFile file(below_a_file); }),
              AllOf(HasSubstr(below_a_file), HasSubstr("Not a directory")));
  const std::string nowhere = folder.File("missing/x");
  EXPECT_THAT(UserErrorOf([&] { AtomicFile file(nowhere); }),
              AllOf(HasSubstr(nowhere), HasSubstr("No such file or directory")));
  EXPECT_THAT(UserErrorOf([&] { AtomicFile file(folder.path()); }), HasSubstr("it is a folder"));
}

TEST(AtomicFile, ReportsAFailedStreamAndKeepsTheTargetAbsent) {
  const TempFolder folder;
  {
    AtomicFile file(folder.File("out"));
    file.stream().setstate(std::ios::failbit);
    EXPECT_THAT(UserErrorOf([&] { file.Commit(); }), HasSubstr("could not be written completely"));
  }
  EXPECT_THAT(folder.Names(), ElementsAre());
}

TEST(AtomicFile, ReportsAWriteThatTheSystemRefuses) {
  const TempFolder folder;
  // A limit on file sizes stands in for a full disk.
  rlimit usual;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &usual), 0);
  const rlimit tight{100000, usual.rlim_max};
  const auto usual_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  const std::string message = UserErrorOf([&] { WriteFileAtomically(folder.File("out"), std::string(1000000, 'x')); });
  setrlimit(RLIMIT_FSIZE, &usual);
  std::signal(SIGXFSZ, usual_handler);
  EXPECT_THAT(message, HasSubstr("File too large"));
  EXPECT_THAT(folder.Names(), ElementsAre());
}

TEST(AtomicFile, ReportsATargetThatTurnedIntoAFolder) {
  const TempFolder folder;
  {
    AtomicFile file(folder.File("out"));
    std::filesystem::create_directory(folder.File("out"));
    EXPECT_THAT(UserErrorOf([&] { file.Commit(); }), AllOf(HasSubstr("out"), HasSubstr("Is a directory")));
  }
  EXPECT_THAT(folder.Names(), ElementsAre("out"));
}

}  // namespace
}  // namespace arborslam
