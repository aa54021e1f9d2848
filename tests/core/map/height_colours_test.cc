#include "core/map/height_colours.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

// Relative luminance, near enough (ITU-R BT.709 without the gamma).
double Luminance(const Colour& colour) { return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]; }

TEST(ViridisTest, RunsFromDarkBlueToYellowAndOnlyGrowsBrighter) {
  EXPECT_EQ(Viridis(0.0), (Colour{68, 1, 84}));
  EXPECT_EQ(Viridis(1.0), (Colour{253, 231, 37}));
  EXPECT_EQ(Viridis(-3.0), Viridis(0.0));
  EXPECT_EQ(Viridis(7.0), Viridis(1.0));
  for (int i = 0; i < 100; ++i) {
    const Colour lower = Viridis(0.01 * i);
    const Colour higher = Viridis(0.01 * (i + 1));
    EXPECT_GE(Luminance(higher), Luminance(lower)) << i;
    for (size_t channel = 0; channel < 3; ++channel) {
      EXPECT_LE(std::abs(higher[channel] - lower[channel]), 9) << "no steps to be seen";
    }
  }
}

// Ground of this slope with a pole every 5 m.
std::vector<Eigen::Vector3f> HillWithPoles(double slope) {
  Random random(2);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 20000; ++i) {
    const double x = random.Uniform(-20.0, 20.0);
    points.push_back(Eigen::Vector3d(x, random.Uniform(-20.0, 20.0), slope * x).cast<float>());
  }
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      for (int z = 0; z <= 30; ++z) {
        points.push_back(Eigen::Vector3d(5.0 * x, 5.0 * y, 5.0 * slope * x + 0.1 * z).cast<float>());
      }
    }
  }
  return points;
}

TEST(HeightsAboveGroundTest, FollowTheHill) {
  for (const double slope : {0.0, 0.1, 0.27}) {
    const std::vector<Eigen::Vector3f> points = HillWithPoles(slope);
    const std::vector<float> heights = HeightsAboveGround(points);
    ASSERT_EQ(heights.size(), points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      const double truth = points[i].z() - slope * points[i].x();
      // The least of a cell and its neighbours lies up to two cells downhill; that is the same everywhere but for the
      // outermost cells.
      EXPECT_GE(heights[i], truth - 1e-4);
      EXPECT_LE(heights[i], truth + slope * 4.0 + 0.01) << points[i].transpose();
    }
  }
}

TEST(HeightsAboveGroundTest, CrownsWithoutGroundBelowTakeTheirNeighbours) {
  // A crown fills its cell; the ground shows in the next one only.
  const std::vector<Eigen::Vector3f> points = {{1.0f, 1.0f, 3.0f}, {3.0f, 1.0f, 0.5f}};
  EXPECT_THAT(HeightsAboveGround(points), testing::ElementsAre(testing::FloatEq(2.5f), testing::FloatEq(0.0f)));
}

TEST(HeightsAboveGroundTest, OnePointIsItsOwnGround) {
  EXPECT_THAT(HeightsAboveGround({{-7.0f, 4.0f, 12.0f}}), testing::ElementsAre(0.0f));
  EXPECT_TRUE(HeightsAboveGround({}).empty());
}

TEST(ColourByHeightTest, GroundIsDarkAndTopsAreYellowWhereverTheyAre) {
  const std::vector<Eigen::Vector3f> points = HillWithPoles(0.05);
  const std::vector<Colour> colours = ColourByHeight(points);
  ASSERT_EQ(colours.size(), points.size());
  double ground = 0.0;
  for (size_t i = 0; i < 20000; ++i) ground += Luminance(colours[i]) / 20000.0;
  EXPECT_LT(ground, 70.0);
  for (size_t top = 20030; top < points.size(); top += 31) EXPECT_GT(Luminance(colours[top]), 190.0);
}

TEST(ColourByHeightTest, FewPoints) {
  EXPECT_TRUE(ColourByHeight({}).empty());
  EXPECT_THAT(ColourByHeight({{1.0f, 2.0f, 3.0f}}), testing::ElementsAre(Viridis(0.0)));
  EXPECT_THAT(ColourByHeight({{1.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 2.0f}, {1.0f, 1.0f, 4.0f}}),
              testing::ElementsAre(Viridis(0.0), Viridis(1.0), Viridis(1.0)))
      << "from the percentile on all are yellow";
}

}  // namespace
}  // namespace arborslam
