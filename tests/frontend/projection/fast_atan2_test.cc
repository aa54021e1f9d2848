#include "frontend/projection/fast_atan2.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(FastAtan2Test, IsAsCloseAsItSays) {
  Random random(1);
  for (int i = 0; i < 200000; ++i) {
    const double angle = random.Uniform(-3.14159265, 3.14159265);
    const double range = std::exp(random.Uniform(-5.0, 5.0));
    const auto x = static_cast<float>(range * std::cos(angle));
    const auto y = static_cast<float>(range * std::sin(angle));
    ASSERT_NEAR(FastAtan2(y, x), std::atan2(static_cast<double>(y), static_cast<double>(x)), 4e-6)
        << "x " << x << " y " << y;
  }
}

TEST(FastAtan2Test, KnowsTheAxes) {
  EXPECT_EQ(FastAtan2(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(FastAtan2(0.0f, 2.0f), 0.0f);
  EXPECT_NEAR(FastAtan2(2.0f, 0.0f), 1.5707963f, 4e-6f);
  EXPECT_NEAR(FastAtan2(-2.0f, 0.0f), -1.5707963f, 4e-6f);
  EXPECT_NEAR(FastAtan2(0.0f, -2.0f), 3.1415927f, 4e-6f);
}

TEST(FastAtan2Test, ManyAtOnceAreTheSame) {
  Random random(2);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 133; ++i) {
    points.emplace_back(static_cast<float>(random.Gaussian()), static_cast<float>(random.Gaussian()), 0.0f);
  }
  std::vector<float> azimuths(points.size());
  Azimuths(points.data(), points.size(), azimuths.data());
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(azimuths[i], FastAtan2(points[i].y(), points[i].x()));
}

}  // namespace
}  // namespace arborslam
