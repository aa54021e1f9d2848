#include "frontend/matching/modified_hausdorff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace arborslam {
namespace {

// Paper eq. 9-12, word for word: sort the distances; alpha = K / n is the share of points nearer than D_max, but
// within [alpha_min, alpha_max]; the score is the mean of the K smallest, each at most D_max.
double ScoreByThePaper(std::vector<float> distances, double max_distance, double alpha_min, double alpha_max) {
  std::sort(distances.begin(), distances.end());
  const size_t n = distances.size();
  size_t k = 0;
  while (k < n && distances[k] < max_distance) ++k;
  while (static_cast<double>(k) < alpha_min * static_cast<double>(n) - 1e-9) ++k;
  while (k > 1 && static_cast<double>(k) > alpha_max * static_cast<double>(n) + 1e-9 &&
         static_cast<double>(k - 1) >= alpha_min * static_cast<double>(n) - 1e-9) {
    --k;
  }
  double sum = 0.0;
  for (size_t i = 0; i < k; ++i) sum += std::min<double>(distances[i], max_distance);
  return sum / static_cast<double>(k);
}

TEST(ModifiedHausdorffTest, AgreesWithThePaper) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> size(1, 120);
  std::uniform_real_distribution<float> near_distance(0.0f, 0.2f);
  std::uniform_real_distribution<float> any_distance(0.0f, 1.0f);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const float max_distance = 0.2f;
  for (int trial = 0; trial < 2000; ++trial) {
    MhdOptions options;
    if (trial % 2 == 1) {
      options.alpha_min = 0.05 + 0.9 * share(random);
      options.alpha_max = options.alpha_min + (1.0 - options.alpha_min) * share(random);
    }
    ASSERT_EQ(options.Validate(), "");
    std::vector<float> distances(static_cast<size_t>(size(random)));
    const double outliers = share(random);
    for (float& distance : distances) {
      distance = share(random) < outliers ? any_distance(random) : near_distance(random);
    }
    const std::vector<float> before = distances;
    const MhdResult result = ModifiedHausdorff(&distances, max_distance, options);
    const int num_points = static_cast<int>(before.size());
    EXPECT_NEAR(result.score, ScoreByThePaper(before, max_distance, options.alpha_min, options.alpha_max), 1e-6);
    const auto num_near = std::count_if(before.begin(), before.end(), [&](float d) { return d < max_distance; });
    EXPECT_NEAR(result.inlier_ratio, static_cast<double>(num_near) / num_points, 1e-12);
    EXPECT_EQ(result.num_used, ChooseK(static_cast<int>(num_near), num_points, options));
    std::vector<float> sorted = before;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_FLOAT_EQ(static_cast<float>(result.cutoff),
                    std::min(max_distance, sorted[static_cast<size_t>(result.num_used) - 1]));
  }
}

TEST(ModifiedHausdorffTest, KFollowsTheNearPointsWithinItsLimits) {
  const MhdOptions options;
  EXPECT_EQ(ChooseK(0, 10, options), 7);
  EXPECT_EQ(ChooseK(7, 10, options), 7);
  EXPECT_EQ(ChooseK(8, 10, options), 8);
  EXPECT_EQ(ChooseK(10, 10, options), 8);
  EXPECT_EQ(ChooseK(74, 100, options), 74);
  EXPECT_EQ(ChooseK(0, 0, options), 0);
  EXPECT_EQ(ChooseK(0, 1, options), 1);
  EXPECT_EQ(ChooseK(1, 1, options), 1);
  EXPECT_EQ(ChooseK(0, 2, options), 2);
}

TEST(ModifiedHausdorffTest, KStaysWithinBoundsForEveryCount) {
  for (const auto& [low, high] :
       {std::pair(0.7, 0.8), std::pair(0.01, 0.01), std::pair(1.0, 1.0), std::pair(0.3, 0.9)}) {
    MhdOptions options;
    options.alpha_min = low;
    options.alpha_max = high;
    for (int n = 1; n <= 60; ++n) {
      for (int near = 0; near <= n; ++near) {
        const int k = ChooseK(near, n, options);
        ASSERT_GE(k, 1);
        ASSERT_LE(k, n);
        ASSERT_GE(k, low * n - 1e-9);
        // No whole number may lie between the limits: then the least share rules.
        ASSERT_LT(k, std::max(high * n, low * n + 1.0) + 1e-9);
      }
    }
  }
}

TEST(ModifiedHausdorffTest, WithoutPointsItIsDMax) {
  std::vector<float> none;
  const MhdResult result = ModifiedHausdorff(&none, 0.2, MhdOptions());
  EXPECT_EQ(result.score, 0.2);
  EXPECT_EQ(result.num_used, 0);
  EXPECT_EQ(result.inlier_ratio, 0.0);
}

TEST(ModifiedHausdorffTest, OneAndTwoPoints) {
  std::vector<float> one = {0.05f};
  EXPECT_NEAR(ModifiedHausdorff(&one, 0.2, MhdOptions()).score, 0.05, 1e-7);
  std::vector<float> two = {0.3f, 0.1f};
  const MhdResult result = ModifiedHausdorff(&two, 0.2, MhdOptions());
  EXPECT_EQ(result.num_used, 2);
  EXPECT_NEAR(result.score, 0.15, 1e-7) << "the far one counts as D_max";
  EXPECT_NEAR(result.cutoff, 0.2, 1e-7);
  EXPECT_EQ(result.inlier_ratio, 0.5);
}

TEST(ModifiedHausdorffTest, ADistanceOfDMaxIsNotNear) {
  std::vector<float> distances = {0.25f, 0.25f, 0.25f, 0.25f};
  const MhdResult result = ModifiedHausdorff(&distances, 0.25, MhdOptions());
  EXPECT_EQ(result.inlier_ratio, 0.0);
  EXPECT_EQ(result.score, 0.25);
}

TEST(ModifiedHausdorffTest, ValidatesItsOptions) {
  EXPECT_EQ(MhdOptions().Validate(), "");
  MhdOptions options;
  options.alpha_min = 0.0;
  EXPECT_NE(options.Validate().find("alpha_min"), std::string::npos);
  options = {};
  options.alpha_max = 0.6;
  EXPECT_NE(options.Validate().find("alpha_max"), std::string::npos);
  options.alpha_max = 1.1;
  EXPECT_NE(options.Validate().find("alpha_max"), std::string::npos);
}

}  // namespace
}  // namespace arborslam
