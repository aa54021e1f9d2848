#include "core/config/edit_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace arborslam {
namespace {

// The definition, without memory.
size_t BruteForceDistance(const std::string& a, const std::string& b) {
  if (a.empty()) return b.size();
  if (b.empty()) return a.size();
  const std::string a_rest = a.substr(1);
  const std::string b_rest = b.substr(1);
  const size_t replaced = BruteForceDistance(a_rest, b_rest) + (a[0] == b[0] ? 0 : 1);
  const size_t edited = std::min({replaced, BruteForceDistance(a_rest, b) + 1, BruteForceDistance(a, b_rest) + 1});
  const bool swapped = a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0];
  return swapped ? std::min(edited, BruteForceDistance(a.substr(2), b.substr(2)) + 1) : edited;
}

TEST(EditDistanceTest, KnownWords) {
  EXPECT_EQ(EditDistance("", ""), 0u);
  EXPECT_EQ(EditDistance("", "abc"), 3u);
  EXPECT_EQ(EditDistance("abc", ""), 3u);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(EditDistance("alpha_min", "alpha_min"), 0u);
  EXPECT_EQ(EditDistance("ahpla_min", "alpha_min"), 2u);
  EXPECT_EQ(EditDistance("aplha_min", "alpha_min"), 1u);
}

TEST(EditDistanceTest, EqualsTheDefinitionOnRandomWords) {
  std::mt19937_64 random(1);
  const auto word = [&] {
    std::string text(random() % 6, 'a');
    for (char& c : text) c = static_cast<char>('a' + random() % 3);
    return text;
  };
  for (int i = 0; i < 300; ++i) {
    const std::string a = word();
    const std::string b = word();
    EXPECT_EQ(EditDistance(a, b), BruteForceDistance(a, b)) << a << " " << b;
  }
}

TEST(NearestNameTest, TakesTheFirstOfTheNearest) {
  EXPECT_EQ(NearestName("alfa", {"beta", "alpha", "alga"}), "alga");
  EXPECT_EQ(NearestName("xx", {"ax", "xa"}), "ax");
  EXPECT_EQ(NearestName("anything", {}), "");
}

}  // namespace
}  // namespace arborslam
