#include "core/io/rising_stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(RisingStampsTest, StampsThatRiseAreLeftAlone) {
  const std::vector<double> stamps = {1.0, 1.5, 1.50001, 7.0};
  const RisingStamps rising = MakeRising(stamps);
  EXPECT_EQ(rising.stamps, stamps);
  EXPECT_EQ(rising.num_backwards, 0u);
  EXPECT_EQ(rising.num_changed, 0u);
}

TEST(RisingStampsTest, NoneAndOne) {
  EXPECT_TRUE(MakeRising({}).stamps.empty());
  EXPECT_EQ(MakeRising({3.0}).stamps, std::vector<double>{3.0});
}

TEST(RisingStampsTest, OneThatRanAheadIsMovedAndTheRightOnesStay) {
  const RisingStamps rising = MakeRising({0.0, 1.0, 2.9, 2.2, 2.5, 3.0, 4.0});
  EXPECT_EQ(rising.stamps, (std::vector<double>{0.0, 1.0, 1.6, 2.2, 2.5, 3.0, 4.0}));
  EXPECT_EQ(rising.num_backwards, 1u);
  EXPECT_EQ(rising.num_changed, 1u);
}

TEST(RisingStampsTest, SeveralInARowAreSpreadEvenly) {
  const RisingStamps rising = MakeRising({0.0, 1.0, 1.0, 1.0, 5.0, 6.0});
  EXPECT_EQ(rising.num_backwards, 2u);
  EXPECT_EQ(rising.num_changed, 2u);
  for (size_t i = 1; i < rising.stamps.size(); ++i) EXPECT_GT(rising.stamps[i], rising.stamps[i - 1]) << i;
  EXPECT_EQ(rising.stamps.front(), 0.0);
  EXPECT_EQ(rising.stamps.back(), 6.0);
}

TEST(RisingStampsTest, AClockThatIsSetBackForGoodGoesOnByTheMedianStep) {
  const RisingStamps rising = MakeRising({10.0, 11.0, 12.0, 13.0, 2.0, 3.0});
  EXPECT_EQ(rising.stamps, (std::vector<double>{10.0, 11.0, 12.0, 13.0, 14.0, 15.0}));
  // And one that is set right after the first readings.
  EXPECT_EQ(MakeRising({90.0, 91.0, 5.0, 6.0, 7.0, 8.0}).stamps, (std::vector<double>{3.0, 4.0, 5.0, 6.0, 7.0, 8.0}));
}

TEST(RisingStampsTest, OnlyFallingStampsAreCountedFromOneOfThem) {
  const RisingStamps rising = MakeRising({5.0, 4.0, 3.0});
  EXPECT_EQ(rising.num_changed, 2u);
  for (size_t i = 1; i < 3; ++i) EXPECT_DOUBLE_EQ(rising.stamps[i] - rising.stamps[i - 1], 1.0);
}

// Against the definition: for short sequences, the longest rising subsequence by trying all.
TEST(RisingStampsTest, ChangesAsFewAsPossible) {
  Random random(11);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> stamps;
    for (int i = 0; i < 9; ++i) stamps.push_back(static_cast<double>(i) + 3.0 * random.Gaussian());
    size_t longest = 0;
    for (unsigned chosen = 1; chosen < 1u << stamps.size(); ++chosen) {
      double last = -1e9;
      size_t length = 0;
      for (size_t i = 0; i < stamps.size(); ++i) {
        if ((chosen >> i & 1u) == 0) continue;
        length = stamps[i] > last ? length + 1 : 0;
        if (length == 0) break;
        last = stamps[i];
      }
      longest = std::max(longest, length);
    }
    const RisingStamps rising = MakeRising(stamps);
    EXPECT_EQ(stamps.size() - rising.num_changed, longest);
    size_t num_equal = 0;
    for (size_t i = 0; i < stamps.size(); ++i) {
      num_equal += rising.stamps[i] == stamps[i] ? 1 : 0;
      if (i > 0) {
        EXPECT_GT(rising.stamps[i], rising.stamps[i - 1]);
      }
    }
    EXPECT_GE(num_equal, longest);
  }
}

}  // namespace
}  // namespace arborslam
