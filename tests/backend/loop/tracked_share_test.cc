#include "backend/loop/tracked_share.h"

#include <gtest/gtest.h>

#include <string>

namespace arborslam {
namespace {

// Keyframes that could be put into maps ('x') or not ('.').
std::vector<Keyframe> KeyframesOf(const std::string& inserted) {
  std::vector<Keyframe> keyframes;
  for (const char c : inserted) {
    keyframes.push_back({KeyframeId{static_cast<int>(keyframes.size())}, PlanarScan(), c == 'x'});
  }
  return keyframes;
}

Submap Of(int first, int last) { return {SubmapId{0}, {KeyframeId{first}, KeyframeId{last}}, {}}; }

TEST(TrackedShareTest, OfASubmapCountsAllFromItsFirstKeyframeToItsLast) {
  const TrackedShare share(KeyframesOf("xx..x.xxxx"));
  EXPECT_DOUBLE_EQ(share.Of(Of(0, 1)), 1.0);
  EXPECT_DOUBLE_EQ(share.Of(Of(1, 4)), 0.5);
  EXPECT_DOUBLE_EQ(share.Of(Of(0, 9)), 0.7);
  EXPECT_DOUBLE_EQ(share.Of(Of(3, 3)), 0.0);
  EXPECT_DOUBLE_EQ(share.Of(Submap()), 0.0) << "no keyframes";
}

TEST(TrackedShareTest, AroundEndsWhereTheRunDoes) {
  const TrackedShare share(KeyframesOf("xx..x"));
  EXPECT_DOUBLE_EQ(share.Around(0, 0), 1.0);
  EXPECT_DOUBLE_EQ(share.Around(0, 2), 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(share.Around(3, 1), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(share.Around(2, 100), 0.6);
  EXPECT_DOUBLE_EQ(share.Around(4, 1), 0.5);
}

}  // namespace
}  // namespace arborslam
