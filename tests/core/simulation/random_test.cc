#include "core/simulation/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace arborslam {
namespace {

TEST(RandomTest, IsTheSameOnEveryMachine) {
  Random random(1, 2);
  EXPECT_EQ(random.Bits(), 10116348427443287449ULL);
  EXPECT_EQ(random.Bits(), 18331329602660409995ULL);
}

TEST(RandomTest, StreamsAndSeedsDiffer) {
  std::set<uint64_t> seen;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    for (uint64_t stream = 0; stream < 30; ++stream) {
      Random random(seed, stream);
      for (int i = 0; i < 10; ++i) seen.insert(random.Bits());
    }
  }
  EXPECT_EQ(seen.size(), 30u * 30u * 10u);
}

TEST(RandomTest, NeighbouringStreamsAreUncorrelated) {
  constexpr int kDraws = 20000;
  double sum = 0.0;
  for (int i = 0; i < kDraws; ++i) sum += Random(7, i).Gaussian() * Random(7, i + 1).Gaussian();
  EXPECT_LT(std::abs(sum / kDraws), 4.0 / std::sqrt(kDraws));
}

TEST(RandomTest, UniformFillsItsInterval) {
  constexpr int kDraws = 100000;
  Random random(3);
  double sum = 0.0;
  double low = 10.0;
  double high = -10.0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.Uniform(-2.0, 3.0);
    sum += value;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  EXPECT_GE(low, -2.0);
  EXPECT_LT(high, 3.0);
  EXPECT_LT(low, -1.99);
  EXPECT_GT(high, 2.99);
  EXPECT_NEAR(sum / kDraws, 0.5, 4.0 * 5.0 / std::sqrt(12.0 * kDraws));
}

TEST(RandomTest, GaussianHasTheMomentsAndTailsOfANormalDistribution) {
  constexpr int kDraws = 400000;
  Random random(4);
  double sum = 0.0;
  double square = 0.0;
  double fourth = 0.0;
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.Gaussian();
    sum += value;
    square += value * value;
    fourth += value * value * value * value;
    if (std::abs(value) > 2.0) ++beyond_two;
  }
  // Four standard errors each.
  EXPECT_NEAR(sum / kDraws, 0.0, 4.0 / std::sqrt(kDraws));
  EXPECT_NEAR(square / kDraws, 1.0, 4.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourth / kDraws, 3.0, 4.0 * std::sqrt(96.0 / kDraws));
  EXPECT_NEAR(static_cast<double>(beyond_two) / kDraws, 0.0455, 4.0 * std::sqrt(0.0455 / kDraws));
}

TEST(RandomTest, ExponentialHasMeanAndVarianceOne) {
  constexpr int kDraws = 200000;
  Random random(5);
  double sum = 0.0;
  double square = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.Exponential();
    ASSERT_GE(value, 0.0);
    sum += value;
    square += value * value;
  }
  EXPECT_NEAR(sum / kDraws, 1.0, 4.0 / std::sqrt(kDraws));
  EXPECT_NEAR(square / kDraws, 2.0, 4.0 * std::sqrt(20.0 / kDraws));
}

}  // namespace
}  // namespace arborslam
