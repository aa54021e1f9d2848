#include "core/io/text_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(TextReader, GivesTheFieldsOfEveryRecordWithItsLine) {
  const TempFolder folder;
  TextReader reader(folder.Write("a.txt", "\n  # comment\none\t two\r\n \n3 # 4"));
  ASSERT_TRUE(reader.Next());
  EXPECT_THAT(reader.fields(), ElementsAre("one", "two"));
  EXPECT_EQ(reader.line_number(), 3u);
  EXPECT_THAT(reader.Place(), HasSubstr("a.txt, line 3"));
  ASSERT_TRUE(reader.Next());
  EXPECT_THAT(reader.fields(), ElementsAre("3", "#", "4"));
  EXPECT_EQ(reader.line_number(), 5u);
  EXPECT_FALSE(reader.Next());
}

TEST(TextReader, ReadsNumbersStrictly) {
  const TempFolder folder;
  TextReader reader(folder.Write("a.txt", "1.5 +2 -3e-2 1.5.2 0x10 -7 2147483648 nan 4.0"));
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.Number(0, "x"), 1.5);
  EXPECT_EQ(reader.Number(1, "x"), 2.0);
  EXPECT_EQ(reader.Number(2, "x"), -0.03);
  EXPECT_EQ(reader.Integer(1, "id"), 2);
  EXPECT_EQ(reader.Integer(5, "id"), -7);
  EXPECT_THAT(UserErrorOf([&] { reader.Number(3, "x"); }), AllOf(HasSubstr("line 1"), HasSubstr("x '1.5.2'")));
  EXPECT_THAT(UserErrorOf([&] { reader.Number(4, "x"); }), HasSubstr("'0x10' is not a number"));
  EXPECT_THAT(UserErrorOf([&] { reader.Number(7, "x"); }), HasSubstr("'nan' is not finite"));
  EXPECT_THAT(UserErrorOf([&] { reader.Integer(6, "id"); }), HasSubstr("'2147483648' is beyond what is supported"));
  EXPECT_THAT(UserErrorOf([&] { reader.Integer(8, "id"); }), HasSubstr("'4.0' is not an integer"));
  EXPECT_THAT(UserErrorOf([&] { reader.ExpectFields(3, "a b c"); }),
              AllOf(HasSubstr("9 columns instead of 3"), HasSubstr("'a b c'")));
}

TEST(TextReader, LinesOfAnyReasonableLengthAreReadAndLongerOnesRefused) {
  const TempFolder folder;
  const std::string longest(65535, 'x');
  TextReader reader(folder.Write("a.txt", longest.substr(1) + "\n" + longest + "x\n"));
  ASSERT_TRUE(reader.Next());
  EXPECT_EQ(reader.fields()[0].size(), 65534u);
  EXPECT_THAT(UserErrorOf([&] { reader.Next(); }), AllOf(HasSubstr("line 2"), HasSubstr("longer than 65535")));
}

TEST(TextReader, AZeroByteDoesNotHideTheRestOfItsLine) {
  const TempFolder folder;
  TextReader reader(folder.Write("a.txt", std::string("1 2\n1 2\0 3\n", 12)));
  ASSERT_TRUE(reader.Next());
  EXPECT_THAT(UserErrorOf([&] { reader.Next(); }), AllOf(HasSubstr("line 2"), HasSubstr("zero byte")));
  TextReader last(folder.Write("b.txt", std::string("1\0", 2)));
  EXPECT_THAT(UserErrorOf([&] { last.Next(); }), AllOf(HasSubstr("line 1"), HasSubstr("zero byte")));
}

TEST(ShortestText, ReadsBackAsTheSameDouble) {
  EXPECT_EQ(ShortestText(0.1), "0.1");
  EXPECT_EQ(ShortestText(-2.0), "-2");
  std::mt19937_64 random(9);
  for (int i = 0; i < 10000; ++i) {
    const uint64_t bits = random();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(std::strtod(ShortestText(value).c_str(), nullptr), value);
  }
}

}  // namespace
}  // namespace arborslam
