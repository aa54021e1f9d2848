#include "frontend/tracking/error_quantile.h"

#include <gtest/gtest.h>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(ErrorQuantileTest, SaysNothingBeforeThirtyErrors) {
  ErrorQuantile errors;
  for (int i = 0; i < 29; ++i) errors.Add(1.0);
  EXPECT_FALSE(errors.Sigma(1.0));
  errors.Add(1.0);
  ASSERT_TRUE(errors.Sigma(1.0));
  EXPECT_NEAR(*errors.Sigma(1.0), 1.0 / 1.96, 1e-12);
  EXPECT_NEAR(*errors.Sigma(1.5), 1.5 / 1.96, 1e-12);
}

TEST(ErrorQuantileTest, IsTheSigmaOfNormalErrorsWhateverAFewOthersAre) {
  Random random(1);
  ErrorQuantile errors;
  for (int i = 0; i < 200; ++i) errors.Add(i % 50 == 0 ? 100.0 : 0.3 * random.Gaussian());
  EXPECT_NEAR(*errors.Sigma(1.0), 0.3, 0.08);
}

TEST(ErrorQuantileTest, ForgetsWhatIsLongAgo) {
  ErrorQuantile errors;
  for (int i = 0; i < 200; ++i) errors.Add(-5.0);
  for (int i = 0; i < 200; ++i) errors.Add(0.1);
  EXPECT_NEAR(*errors.Sigma(1.0), 0.1 / 1.96, 1e-12);
}

}  // namespace
}  // namespace arborslam
