#include "core/io/sweep_stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Optional;

TEST(ParseStamp, TakesSecondsAndTheSmallerUnitsSince1970) {
  EXPECT_EQ(ParseStamp("12.5"), 12.5);
  EXPECT_EQ(ParseStamp("-3"), -3.0);
  EXPECT_EQ(ParseStamp("+1.5e1"), 15.0);
  EXPECT_EQ(ParseStamp("0.000000000000000000e+00"), 0.0);
  EXPECT_EQ(ParseStamp("1664464000.25"), 1664464000.25);
  EXPECT_EQ(ParseStamp("1664464000250"), 1664464000.25);
  EXPECT_EQ(ParseStamp("1664464000250000"), 1664464000.25);
  EXPECT_EQ(ParseStamp("1664464000250000000"), 1664464000.25);
  EXPECT_THAT(ParseStamp("1.66446400025e+18"), Optional(DoubleNear(1664464000.25, 1e-6)));
  EXPECT_EQ(ParseStamp("1000000000000000000000"), 1e21) << "In no unit a moment of these centuries: seconds.";
  for (const char* text : {"", "+", "x", "1,5", "1 ", "nan", "inf", "0x10", "1.5s", "+-1"}) {
    EXPECT_EQ(ParseStamp(text), std::nullopt) << text;
  }
}

TEST(ReadSweepStamps, TakesNumbersAndKittisDates) {
  const TempFolder folder;
  const std::string path = folder.Write("timestamps.txt",
                                        "# start\n2011-09-26 13:02:25.964389445\r\n\n1970-01-02 00:00:00\n"
                                        "2000-02-29 23:59:59.5\n2000-03-01 00:00:00\n7.25");
  const SweepStamps stamps = ReadSweepStamps(path);
  EXPECT_THAT(stamps.seconds,
              ElementsAre(DoubleNear(1317042145.964389445, 1e-6), 86400.0, 951868799.5, 951868800.0, 7.25));
  EXPECT_THAT(stamps.line_numbers, ElementsAre(2u, 4u, 5u, 6u, 7u));
}

TEST(ReadSweepStamps, NamesTheLineThatIsNoStamp) {
  const TempFolder folder;
  const auto error = [&](const std::string& line) {
    const std::string path = folder.Write("times.txt", "1.0\n" + line + "\n");
    return UserErrorOf([&] { ReadSweepStamps(path); });
  };
  for (const char* line :
       {"one", "1 2", "1 2 3", "nan", "1.0,", "2011-09-26", "2011-13-26 13:02:25", "2011-09-32 13:02:25",
        "2011-00-26 13:02:25", "2011-09-26 13:60:25", "2011-09-26 13:02", "2011-09-26 13:02:25:1",
        "2011-09-26 -1:02:25", "2011-09 13:02:25", "2011-09-26 13:02:nan", "2011-09-26 13:02:1e9"}) {
    EXPECT_THAT(error(line), AllOf(HasSubstr("times.txt, line 2"), HasSubstr("is no stamp"))) << line;
  }
  EXPECT_THAT(UserErrorOf([&] { ReadSweepStamps(folder.Write("empty", "")); }), HasSubstr("is empty"));
}

TEST(StampsOfNames, TakesNamesThatAreStamps) {
  EXPECT_THAT(StampsOfNames({"1664464000.125000", "1664464000.225000"}),
              Optional(ElementsAre(1664464000.125, 1664464000.225)));
  EXPECT_THAT(StampsOfNames({"1664464000250000000", "cloud_1664464001250000000"}),
              Optional(ElementsAre(1664464000.25, 1664464001.25)));
  EXPECT_THAT(StampsOfNames({"1664464000_000000005", "1664464000_5000"}),
              Optional(ElementsAre(DoubleNear(1664464000.0, 1e-6), DoubleNear(1664464000.000005, 1e-6))));
  EXPECT_THAT(StampsOfNames({"0.000", "0.100", "12.3456"}), Optional(ElementsAre(0.0, 0.1, 12.3456)));
  EXPECT_THAT(StampsOfNames({"1664464000"}), Optional(ElementsAre(1664464000.0)));
  EXPECT_THAT(StampsOfNames({"vlp16_1664464000.125", "2022-09-29_vlp16_1664464001_500000000"}),
              Optional(ElementsAre(1664464000.125, 1664464001.5)));
}

TEST(StampsOfNames, TakesNumbersForNumbers) {
  EXPECT_EQ(StampsOfNames({"0000000000", "0000000001"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"1.0", "1.1"}), std::nullopt) << "Versions, not seconds.";
  EXPECT_EQ(StampsOfNames({"1664464000.125", "start"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"1664464000.125", "1664464000.1250"}), std::nullopt) << "Twice the same.";
  EXPECT_EQ(StampsOfNames({"1664464000.125a"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"1664464000_1_2"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"1664464000_12345678901"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"12_345678901"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"vlp16_12.345"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"2022-09-29-16-00-00"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({"20220929"}), std::nullopt);
  EXPECT_EQ(StampsOfNames({""}), std::nullopt);
}

TEST(SweepDurationFromStamps, IsTheMedianStep) {
  const SweepDuration duration = SweepDurationFromStamps({0.0, 0.1, 0.2, 0.7, 0.8, 0.8, 0.5});
  EXPECT_NEAR(duration.seconds, 0.1, 1e-12);
  EXPECT_FALSE(duration.is_assumed);
  EXPECT_NEAR(SweepDurationFromStamps({0.0, 0.2003, 0.4006}).seconds, 0.2003, 1e-12) << "5 Hz, not quite.";
  EXPECT_NEAR(SweepDurationFromStamps({0.0, 0.05}).seconds, 0.05, 1e-12);
}

TEST(SweepDurationFromStamps, IsAssumedWhenTheStampsDoNotTell) {
  const SweepDuration sparse = SweepDurationFromStamps({0.0, 1.0, 2.0, 2.1, 3.1});
  EXPECT_EQ(sparse.seconds, 0.1);
  EXPECT_TRUE(sparse.is_assumed);
  EXPECT_EQ(sparse.median_step, 1.0);
  for (const std::vector<double>& stamps : {std::vector<double>{}, {5.0}, {5.0, 5.0}, {5.0, 4.0, 3.0}}) {
    const SweepDuration none = SweepDurationFromStamps(stamps);
    EXPECT_EQ(none.seconds, 0.1);
    EXPECT_TRUE(none.is_assumed);
    EXPECT_EQ(none.median_step, 0.0);
  }
}

}  // namespace
}  // namespace arborslam
