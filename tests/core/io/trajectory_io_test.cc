#include "core/io/trajectory_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "core/geometry/angles.h"
#include "core/io/npz.h"
#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr char kGoodLine[] = "1.0 0 0 0 0 0 0 1\n";

std::string ErrorOfText(const std::string& text) {
  const TempFolder folder;
  const std::string path = folder.Write("t.tum", text);
  return UserErrorOf([&] { ReadTrajectory(path); });
}

std::string ErrorOfArrays(const std::map<std::string, NpyArray>& arrays) {
  const TempFolder folder;
  WriteNpz(folder.File("t.npz"), arrays);
  return UserErrorOf([&] { ReadTrajectory(folder.File("t.npz")); });
}

TEST(Tum, ReadsPosesCommentsAndCarriageReturns) {
  const TempFolder folder;
  const Trajectory3 read = ReadTrajectory(folder.Write(
      "t.tum", "# a comment\r\n\r\n  1.5\t1 2 3 0 0 0.70710678 0.70710678\r\n# another\n+2e0 -1 .5 0 0 0 0 -1"));
  ASSERT_EQ(read.poses.size(), 2u);
  EXPECT_TRUE(read.has_orientation);
  EXPECT_EQ(read.poses[0].stamp, 1.5);
  EXPECT_EQ(read.poses[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(read.poses[0].orientation.norm(), 1.0, 1e-15);
  EXPECT_NEAR(ToPlanar(read)[0].pose.theta(), kPi / 2.0, 1e-9);
  EXPECT_EQ(read.poses[1].stamp, 2.0);
  EXPECT_EQ(read.poses[1].position, Eigen::Vector3d(-1, 0.5, 0));
}

TEST(Tum, PlanarPosesReadBack) {
  const TempFolder folder;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(-500.0, 500.0);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  Trajectory written;
  for (int i = 0; i < 200; ++i) {
    written.push_back({1.6e9 + 0.25 * i, SE2(position(random), position(random), angle(random))});
  }
  WriteTum(folder.File("t.tum"), written);
  const Trajectory3 lifted = ReadTrajectory(folder.File("t.tum"));
  const Trajectory read = ToPlanar(lifted);
  ASSERT_EQ(read.size(), written.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].stamp, written[i].stamp);
    EXPECT_TRUE(read[i].pose.IsApprox(written[i].pose, 1e-8)) << read[i].pose << " " << written[i].pose;
    EXPECT_EQ(lifted.poses[i].position.z(), 0.0);
  }
}

TEST(Tum, SpatialPosesReadBack) {
  const TempFolder folder;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  Trajectory3 written;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Quaterniond orientation(normal(random), normal(random), normal(random), normal(random));
    written.poses.push_back({0.1 * i, {normal(random), normal(random), normal(random)}, orientation.normalized()});
  }
  WriteTum(folder.File("t.tum"), written);
  const Trajectory3 read = ReadTrajectory(folder.File("t.tum"));
  ASSERT_EQ(read.poses.size(), written.poses.size());
  for (size_t i = 0; i < read.poses.size(); ++i) {
    EXPECT_NEAR(read.poses[i].stamp, written.poses[i].stamp, 1e-9);
    EXPECT_LT((read.poses[i].position - written.poses[i].position).norm(), 1e-8);
    EXPECT_LT((read.poses[i].orientation.coeffs() - written.poses[i].orientation.coeffs()).norm(), 1e-8);
  }
}

TEST(Tum, BeginsWithFramesAndUnitsAndIsWrittenToNineDecimals) {
  const TempFolder folder;
  WriteTum(folder.File("t.tum"), Trajectory{{1.25, SE2(1.0, -2.0, 0.0)}});
  const std::string text = ReadWhole(folder.File("t.tum"));
  EXPECT_THAT(text, StartsWith("# stamp = middle of sweep [s], T_map_base"));
  EXPECT_THAT(text, HasSubstr("\n1.250000000 1.000000000 -2.000000000 0.000000000 0.000000000 0.000000000 "
                              "0.000000000 1.000000000\n"));
}

TEST(Tum, MalformedLinesAreNamed) {
  const std::string good = kGoodLine;
  EXPECT_THAT(ErrorOfText(good + "2.0 0 0 0 0 0 1\n"), AllOf(HasSubstr("t.tum, line 2"), HasSubstr("7 columns")));
  EXPECT_THAT(ErrorOfText("# c\n\n2.0 0 0 0 0 0 0 1 9\n"), AllOf(HasSubstr("line 3"), HasSubstr("9 columns")));
  EXPECT_THAT(ErrorOfText(good + "2.0 nan 0 0 0 0 0 1\n"), AllOf(HasSubstr("line 2"), HasSubstr("'nan'")));
  EXPECT_THAT(ErrorOfText("inf 0 0 0 0 0 0 1\n"), HasSubstr("stamp 'inf' is not finite"));
  EXPECT_THAT(ErrorOfText("1e999 0 0 0 0 0 0 1\n"), HasSubstr("stamp '1e999'"));
  EXPECT_THAT(ErrorOfText("1.0 0 0 0 0 0 0 1.5x\n"), HasSubstr("qw '1.5x' is not a number"));
  EXPECT_THAT(ErrorOfText("1,0 0 0 0 0 0 0 1\n"), HasSubstr("'1,0'"));
  EXPECT_THAT(ErrorOfText("+-1 0 0 0 0 0 0 1\n"), HasSubstr("'+-1'"));
  EXPECT_THAT(ErrorOfText("+ 0 0 0 0 0 0 1\n"), HasSubstr("'+'"));
  EXPECT_THAT(ErrorOfText("1.0 0 0 0 0 0 0 0\n"), AllOf(HasSubstr("line 1"), HasSubstr("norm 0")));
  EXPECT_THAT(ErrorOfText("1.0 0 0 0 1 0 0 1\n"), HasSubstr("quaternion of norm 1.41"));
  EXPECT_THAT(ErrorOfText("1.0 0 0 0 1e200 0 0 1\n"), HasSubstr("quaternion of norm"));
}

TEST(Tum, StampsMustIncrease) {
  EXPECT_THAT(ErrorOfText("2.5 0 0 0 0 0 0 1\n1.5 0 0 0 0 0 0 1\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("1.5, not later than 2.5")));
  EXPECT_THAT(ErrorOfText(std::string(kGoodLine) + kGoodLine), HasSubstr("not later than 1 before it"));
}

TEST(Tum, FilesWithoutPosesAreErrors) {
  EXPECT_THAT(ErrorOfText(""), HasSubstr("is empty"));
  EXPECT_THAT(ErrorOfText("# only a comment\n"), HasSubstr("holds no poses"));
  EXPECT_THAT(ErrorOfText(std::string(1 << 20, 'x')), AllOf(HasSubstr("line 1"), HasSubstr("longer than")));
  const std::string message = ErrorOfText("\x89PNG\x1b[31m " + std::string(50, '\1'));
  EXPECT_THAT(message, HasSubstr("2 columns"));
  EXPECT_EQ(message.find('\x1b'), std::string::npos);
  EXPECT_THAT(UserErrorOf([] { ReadTrajectory("/nowhere/t.tum"); }), HasSubstr("does not exist"));
  EXPECT_THAT(UserErrorOf([] { ReadTrajectory("/"); }), HasSubstr("is a folder"));
}

TEST(Tum, AFileThatCannotBeWrittenIsAnError) {
  const TempFolder folder;
  const std::string path = folder.Write("file", "") + "/t.tum";
  EXPECT_THAT(UserErrorOf([&] { WriteTum(path, Trajectory{}); }), HasSubstr(path));
}

TEST(PullallyReference, GivesPositionsWithoutOrientation) {
  const TempFolder folder;
  WriteNpz(folder.File("t.npz"), {{"gnss_rotated_c", {{2, 2}, {0, 0, 3, 4}}}, {"time", {{2}, {5, 9}}}});
  const Trajectory3 read = ReadTrajectory(folder.File("t.npz"));
  EXPECT_FALSE(read.has_orientation);
  ASSERT_EQ(read.poses.size(), 2u);
  EXPECT_EQ(read.poses[1].stamp, 9.0);
  EXPECT_EQ(read.poses[1].position, Eigen::Vector3d(3, 4, 0));
  EXPECT_EQ(read.poses[1].orientation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
}

TEST(PullallyReference, IsStampedByIndexLikeItsScansWhenTheTimeIsAbsent) {
  const TempFolder folder;
  WriteNpz(folder.File("t.npz"), {{"gnss_rotated_c", {{2, 2}, {0, 0, 3, 4}}}});
  EXPECT_EQ(ReadTrajectory(folder.File("t.npz")).poses[1].stamp, 1.0);
}

TEST(PullallyReference, OfTheSiteIsEastAndNorth) {
  const TempFolder folder;
  WriteNpz(folder.File("t.npz"), {{"gnss_rotated_c", {{2, 2}, {0, 0, 3, 4}}},
                                  {"gnss_data", {{2, 3}, {500100, 5890200, 31, 500103, 5890204, 32}}}});
  const Trajectory3 read = ReadTrajectory(folder.File("t.npz"), ReferenceFrame::kOfSite);
  EXPECT_FALSE(read.has_orientation);
  ASSERT_EQ(read.poses.size(), 2u);
  EXPECT_EQ(read.poses[1].position, Eigen::Vector3d(500103, 5890204, 0));
  WriteNpz(folder.File("one.npz"), {{"gnss_data", {{2, 1}, {1, 2}}}});
  EXPECT_THROW(ReadTrajectory(folder.File("one.npz"), ReferenceFrame::kOfSite), UserError);
  EXPECT_THROW(ReadTrajectory(folder.File("one.npz")), UserError);
}

TEST(PullallyReference, WrongArraysAreErrors) {
  const NpyArray positions{{2, 2}, {0, 0, 3, 4}};
  EXPECT_THAT(ErrorOfArrays({{"scan0", positions}}),
              AllOf(HasSubstr("no array 'gnss_rotated_c'"), HasSubstr("'scan0'")));
  EXPECT_THAT(ErrorOfArrays({{"gnss_rotated_c", {{4}, {0, 0, 3, 4}}}}), HasSubstr("(4,)"));
  EXPECT_THAT(ErrorOfArrays({{"gnss_rotated_c", {{1, 3}, {0, 0, 3}}}}), HasSubstr("(1, 3)"));
  EXPECT_THAT(ErrorOfArrays({{"gnss_rotated_c", {{0, 2}, {}}}}), HasSubstr("(0, 2)"));
  EXPECT_THAT(ErrorOfArrays({{"gnss_rotated_c", {{2, 2}, {0, 0, kNaN, 4}}}, {"time", {{2}, {1, 2}}}}),
              HasSubstr("'gnss_rotated_c', record 1"));
  EXPECT_THAT(ErrorOfArrays({{"gnss_rotated_c", positions}, {"time", {{2}, {2, 1}}}}), HasSubstr("'time', record 1"));
  EXPECT_THAT(ErrorOfArrays({{"gnss_rotated_c", positions}, {"time", {{3}, {1, 2, 3}}}}), HasSubstr("(3,)"));
}

TEST(PullallyReference, OfTheRecordingStartsAtTheOriginAndGoes150Metres) {
  const std::string path = DataFolder() + "/pullally/p_v2_d1.npz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set ARBORSLAM_DATA";
  const Trajectory3 reference = ReadTrajectory(path);
  ASSERT_EQ(reference.poses.size(), 546u);
  EXPECT_LT(reference.poses[0].position.norm(), 1e-6);
  double length = 0.0;
  for (size_t i = 1; i < reference.poses.size(); ++i) {
    length += (reference.poses[i].position - reference.poses[i - 1].position).norm();
  }
  EXPECT_NEAR(length, 150.0, 15.0);
}

}  // namespace
}  // namespace arborslam
