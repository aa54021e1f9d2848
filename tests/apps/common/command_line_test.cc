#include "apps/common/command_line.h"

#include <gflags/gflags.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

DEFINE_string(test_text, "default", "for this test");
DEFINE_int32(test_count, 1, "for this test");
DEFINE_double(test_length, 1.5, "for this test");
DEFINE_bool(test_switch, false, "for this test");

namespace arborslam {
namespace {

using Strings = std::vector<std::string>;

const Strings kKnown = {"test_text", "test_count", "test_length", "test_switch"};

class SetFlagsTest : public testing::Test {
 private:
  gflags::FlagSaver saver_;
};

std::string ErrorOf(const Strings& arguments) {
  try {
    SetFlags(arguments, kKnown, {"help"});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST_F(SetFlagsTest, BothSpellingsOfAValue) {
  SetFlags({"--test_text=a b", "--test_count", "7", "--test_length", "-2.5"}, kKnown, {});
  EXPECT_EQ(FLAGS_test_text, "a b");
  EXPECT_EQ(FLAGS_test_count, 7);
  EXPECT_EQ(FLAGS_test_length, -2.5);
  SetFlags({"--test_text="}, kKnown, {});
  EXPECT_EQ(FLAGS_test_text, "");
  SetFlags({"--test_text=a=b", "--test_count=1", "--test_count=2"}, kKnown, {});
  EXPECT_EQ(FLAGS_test_text, "a=b");
  EXPECT_EQ(FLAGS_test_count, 2);
}

TEST_F(SetFlagsTest, BooleansNeedNoValue) {
  SetFlags({"--test_switch", "--test_count=3"}, kKnown, {});
  EXPECT_TRUE(FLAGS_test_switch);
  SetFlags({"--notest_switch"}, kKnown, {});
  EXPECT_FALSE(FLAGS_test_switch);
  SetFlags({"--test_switch=true"}, kKnown, {});
  EXPECT_TRUE(FLAGS_test_switch);
}

TEST_F(SetFlagsTest, AnUnknownFlagNamesTheNearest) {
  EXPECT_EQ(ErrorOf({"--test_cuont=3"}), "unknown flag --test_cuont; the nearest is --test_count, all are in --help");
  EXPECT_EQ(ErrorOf({"--hlep"}), "unknown flag --hlep; the nearest is --help, all are in --help");
  EXPECT_NE(ErrorOf({"--notest_text"}).find("unknown flag --notest_text"), std::string::npos);
  EXPECT_NE(ErrorOf({"--"}).find("unknown flag --;"), std::string::npos);
  // gflags' own flags are not the program's.
  EXPECT_NE(ErrorOf({"--flagfile=x"}).find("unknown flag --flagfile"), std::string::npos);
  EXPECT_NE(ErrorOf({"--logtostderr"}).find("unknown flag --logtostderr"), std::string::npos);
}

TEST_F(SetFlagsTest, RefusesMissingAndUnsuitableValuesAndStrayArguments) {
  EXPECT_EQ(ErrorOf({"--test_text"}), "--test_text needs a value");
  EXPECT_EQ(ErrorOf({"--test_text", "--test_switch"}), "--test_text needs a value");
  EXPECT_EQ(ErrorOf({"--test_count=3x"}), "--test_count is '3x' but must be a whole number");
  EXPECT_EQ(ErrorOf({"--test_count", "99999999999"}), "--test_count is '99999999999' but must be a whole number");
  EXPECT_EQ(ErrorOf({"--test_length", "wide"}), "--test_length is 'wide' but must be a number");
  EXPECT_EQ(ErrorOf({"--test_switch=perhaps"}), "--test_switch is 'perhaps' but must be true or false");
  EXPECT_EQ(ErrorOf({"--test_switch", "stray"}), "argument 'stray' belongs to no flag; see --help");
  EXPECT_EQ(ErrorOf({"-test_switch"}), "argument '-test_switch' belongs to no flag; see --help");
}

TEST(FlagsDefinedBesideTest, FindsThisFolderOnly) {
  const Strings names = FlagsDefinedBeside(__FILE__);
  for (const std::string& name : kKnown) EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  EXPECT_EQ(std::count(names.begin(), names.end(), "flagfile"), 0);
  EXPECT_EQ(std::count(names.begin(), names.end(), "logtostderr"), 0);
}

TEST(ExtractMultiFlagTest, CollectsEveryValueAndLeavesTheRest) {
  Strings arguments = {"--quiet", "--set",   "a=1", "b=2",   "--input", "x",         "--set=c=3",
                       "d=4",     "--setup", "y",   "--set", "e=--5",   "--output=z"};
  EXPECT_EQ(ExtractMultiFlag(&arguments, "set"), (Strings{"a=1", "b=2", "c=3", "d=4", "e=--5"}));
  EXPECT_EQ(arguments, (Strings{"--quiet", "--input", "x", "--setup", "y", "--output=z"}));
  EXPECT_TRUE(ExtractMultiFlag(&arguments, "set").empty());
  EXPECT_EQ(arguments.size(), 6u);
}

TEST(ExtractMultiFlagTest, AFlagWithoutValueIsAnError) {
  for (Strings arguments :
       {Strings{"--set"}, Strings{"--set", "--quiet"}, Strings{"--set="}, Strings{"--set", "a=1", "--set"}}) {
    EXPECT_THROW(ExtractMultiFlag(&arguments, "set"), UsageError);
  }
}

}  // namespace
}  // namespace arborslam
