#include "core/map/ids.h"

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <type_traits>

namespace arborslam {
namespace {

// The point of the types: the number of one thing cannot be passed for that of another, nor be made up by accident.
static_assert(!std::is_convertible_v<KeyframeId, SubmapId>);
static_assert(!std::is_convertible_v<int, NodeId>);
static_assert(!std::is_convertible_v<KeyframeId, int>);

TEST(IdsTest, DefaultNamesNothing) {
  EXPECT_EQ(KeyframeId().value, -1);
  EXPECT_EQ(NodeId().value, -1);
}

TEST(IdsTest, CompareByNumber) {
  EXPECT_EQ(KeyframeId{3}, KeyframeId{3});
  EXPECT_NE(KeyframeId{3}, KeyframeId{4});
  EXPECT_LT(SubmapId{3}, SubmapId{4});
  EXPECT_FALSE(SubmapId{3} < SubmapId{3});
}

TEST(IdsTest, NodesOfDifferentKindsDiffer) {
  EXPECT_FALSE(NodeId(KeyframeId{3}) == NodeId(SubmapId{3}));
  EXPECT_TRUE(NodeId(SubmapId{3}) == NodeId(SubmapId{3}));
  EXPECT_FALSE(NodeId(SubmapId{3}) == NodeId(SubmapId{4}));
}

TEST(IdsTest, NodesAreStrictlyOrdered) {
  std::set<NodeId> nodes;
  for (int i = 0; i < 5; ++i) {
    nodes.insert(SubmapId{i});
    nodes.insert(KeyframeId{i});
    nodes.insert(KeyframeId{i});
  }
  EXPECT_EQ(nodes.size(), 10u);
  EXPECT_EQ(nodes.count(SubmapId{4}), 1u);
  EXPECT_EQ(nodes.count(SubmapId{5}), 0u);
  // Keyframes first, by number: the order in which results are written.
  EXPECT_TRUE(*nodes.begin() == NodeId(KeyframeId{0}));
  EXPECT_TRUE(*nodes.rbegin() == NodeId(SubmapId{4}));
}

TEST(IdsTest, PrintsKindAndNumber) {
  std::ostringstream text;
  text << NodeId(KeyframeId{3}) << ", " << NodeId(SubmapId{0});
  EXPECT_EQ(text.str(), "keyframe 3, submap 0");
}

}  // namespace
}  // namespace arborslam
