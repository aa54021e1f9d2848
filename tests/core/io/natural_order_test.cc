#include "core/io/natural_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

using testing::ElementsAre;

TEST(NaturallyLess, NumbersCountByTheirValue) {
  std::vector<std::string> names = {"scan10", "scan9", "b", "scan010", "a2b10", "a2b9", "", "a10", "scan", "7", "0007"};
  std::sort(names.begin(), names.end(), NaturallyLess);
  EXPECT_THAT(names, ElementsAre("", "7", "0007", "a2b9", "a2b10", "a10", "b", "scan", "scan9", "scan10", "scan010"));
  EXPECT_TRUE(NaturallyLess("x99999999999999999999998", "x99999999999999999999999"));
  EXPECT_TRUE(NaturallyLess("x99999999999999999999999", "x100000000000000000000000"));
}

TEST(NaturallyLess, IsAStrictTotalOrder) {
  Random random(1);
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) {
    std::string name;
    const int length = static_cast<int>(random.Uniform(0.0, 6.0));
    for (int j = 0; j < length; ++j) name += "019a/\xe4"[static_cast<int>(random.Uniform(0.0, 6.0))];
    names.push_back(name);
  }
  for (const std::string& a : names) {
    for (const std::string& b : names) {
      EXPECT_EQ(NaturallyLess(a, b) || NaturallyLess(b, a), a != b) << a << " " << b;
      EXPECT_FALSE(NaturallyLess(a, b) && NaturallyLess(b, a)) << a << " " << b;
      for (const std::string& c : names) {
        EXPECT_TRUE(!NaturallyLess(a, b) || !NaturallyLess(b, c) || NaturallyLess(a, c)) << a << " " << b << " " << c;
      }
    }
  }
}

}  // namespace
}  // namespace arborslam
