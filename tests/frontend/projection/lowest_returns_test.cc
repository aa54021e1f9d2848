#include "frontend/projection/lowest_returns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(LowestReturnsTest, AreTheLowestOfTheirCells) {
  Random random(1);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(static_cast<float>(random.Uniform(-7.0, 7.0)), static_cast<float>(random.Uniform(-7.0, 7.0)),
                        static_cast<float>(random.Gaussian()));
  }
  const Eigen::Vector3f up = Eigen::Vector3f(0.1f, -0.2f, 1.0f).normalized();
  std::map<std::pair<int, int>, Eigen::Vector3f> expected;
  for (const Eigen::Vector3f& p : points) {
    if (std::max(std::abs(p.x()), std::abs(p.y())) >= 6.0f || p.head<2>().norm() < 0.8f) continue;
    const std::pair<int, int> cell(static_cast<int>((p.y() + 6.0f) / 0.5f), static_cast<int>((p.x() + 6.0f) / 0.5f));
    const auto found = expected.find(cell);
    if (found == expected.end() || up.dot(p) < up.dot(found->second)) expected[cell] = p;
  }
  LowestReturns lowest(0.5f, 0.8f, 6.0f);
  for (int repetition = 0; repetition < 2; ++repetition) {
    const std::vector<Eigen::Vector3f>& returns = lowest.Find(points, up);
    ASSERT_EQ(returns.size(), expected.size());
    for (const auto& [cell, point] : expected) EXPECT_THAT(returns, testing::Contains(point));
  }
}

TEST(LowestReturnsTest, NothingGivesNothing) {
  LowestReturns lowest(0.5f, 0.8f, 6.0f);
  EXPECT_TRUE(lowest.Find({}, Eigen::Vector3f::UnitZ()).empty());
  EXPECT_TRUE(lowest.Find({{0.1f, 0.1f, -1.0f}, {50.0f, 0.0f, -1.0f}}, Eigen::Vector3f::UnitZ()).empty());
  EXPECT_EQ(lowest.Find({{1.0f, 0.1f, -1.0f}}, Eigen::Vector3f::UnitZ()).size(), 1u);
}

}  // namespace
}  // namespace arborslam
