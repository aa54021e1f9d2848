#include "frontend/projection/laser_projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Beams at -pi, -pi/2, 0, pi/2.
LaserScan FourBeams(float behind, float right, float ahead, float left) {
  LaserScan scan;
  scan.stamp = 12.5;
  scan.bearing_min = -kPi;
  scan.bearing_increment = 0.5 * kPi;
  scan.ranges = {behind, right, ahead, left};
  return scan;
}

TEST(LaserProjectionTest, PutsReturnsWhereTheyAre) {
  const PlanarScan planar = ProjectLaserScan(FourBeams(kInf, 2.0f, 3.0f, 4.0f), ProjectionOptions());
  EXPECT_EQ(planar.stamp, 12.5);
  ASSERT_EQ(planar.points.size(), 3u);
  EXPECT_TRUE(planar.points[0].isApprox(Eigen::Vector2f(0.0f, -2.0f), 1e-6f));
  EXPECT_TRUE(planar.points[1].isApprox(Eigen::Vector2f(3.0f, 0.0f), 1e-6f));
  EXPECT_TRUE(planar.points[2].isApprox(Eigen::Vector2f(0.0f, 4.0f), 1e-6f));
  EXPECT_TRUE(planar.free_ends.empty());
}

TEST(LaserProjectionTest, LeavesOutWhatIsBehind) {
  EXPECT_EQ(ProjectLaserScan(FourBeams(2.0f, kInf, kInf, kInf), ProjectionOptions()).points.size(), 0u);
  ProjectionOptions all_around;
  all_around.max_bearing = 3.15;
  EXPECT_EQ(ProjectLaserScan(FourBeams(2.0f, kInf, kInf, kInf), all_around).points.size(), 1u);
  ProjectionOptions ahead_only;
  ahead_only.max_bearing = 1.0;
  const PlanarScan planar = ProjectLaserScan(FourBeams(2.0f, 20.0f, 2.0f, 2.0f), ahead_only);
  ASSERT_EQ(planar.points.size(), 1u);
  EXPECT_NEAR(planar.points[0].x(), 2.0f, 1e-6f);
  EXPECT_TRUE(planar.free_ends.empty()) << "a masked beam must not clear either";
}

TEST(LaserProjectionTest, BearingsBeyondPiAreWrappedBeforeTheMask) {
  LaserScan scan;
  scan.bearing_min = 2.0 * kPi - 0.5;  // The same as -0.5.
  scan.bearing_increment = 0.5;
  scan.ranges = {2.0f, 3.0f};
  ProjectionOptions options;
  options.max_bearing = 1.0;
  const PlanarScan planar = ProjectLaserScan(scan, options);
  ASSERT_EQ(planar.points.size(), 2u);
  EXPECT_NEAR(planar.points[1].x(), 3.0f, 1e-5f);
  EXPECT_NEAR(planar.points[1].y(), 0.0f, 1e-5f);
}

TEST(LaserProjectionTest, LimitsOfTheRangeBelongToIt) {
  ProjectionOptions options;
  options.min_range = 0.5;
  options.max_range = 15.0;
  EXPECT_EQ(ProjectLaserScan(FourBeams(kInf, 0.499f, 0.5f, 15.0f), options).points.size(), 2u);
}

TEST(LaserProjectionTest, FarReturnsAreFreeUpToTheLimit) {
  ProjectionOptions options;
  options.max_range = 10.0;
  const PlanarScan planar = ProjectLaserScan(FourBeams(kInf, 12.0f, 2.0f, kInf), options);
  EXPECT_EQ(planar.points.size(), 1u);
  ASSERT_EQ(planar.free_ends.size(), 1u) << "a beam without a return says nothing";
  EXPECT_TRUE(planar.free_ends[0].isApprox(Eigen::Vector2f(0.0f, -10.0f), 1e-6f));
}

TEST(LaserProjectionTest, NotANumberInfiniteNegativeAndNearReturnsAreDropped) {
  const PlanarScan planar = ProjectLaserScan(FourBeams(kInf, kNan, -3.0f, 0.1f), ProjectionOptions());
  EXPECT_TRUE(planar.points.empty());
  EXPECT_TRUE(planar.free_ends.empty());
  ProjectionOptions from_zero;
  from_zero.min_range = 0.0;
  EXPECT_TRUE(ProjectLaserScan(FourBeams(kInf, kNan, -3.0f, -kInf), from_zero).points.empty());
}

TEST(LaserProjectionTest, EmptyScan) {
  const PlanarScan planar = ProjectLaserScan(LaserScan(), ProjectionOptions());
  EXPECT_TRUE(planar.points.empty());
  EXPECT_TRUE(planar.free_ends.empty());
}

// Beams a hundredth of a radian apart, from bearing 0 on.
LaserScan Fan(const std::vector<float>& ranges) {
  LaserScan scan;
  scan.bearing_increment = 0.01;
  scan.ranges = ranges;
  return scan;
}

TEST(LaserProjectionTest, MergesNeighboursIntoTheirMean) {
  ProjectionOptions options;
  options.point_spacing = 0.025;
  // 1 cm apart: the first three lie within 2.5 cm of the first, the fourth begins anew; then a jump in range.
  const PlanarScan planar = ProjectLaserScan(Fan({1.0f, 1.0f, 1.0f, 1.0f, 3.0f}), options);
  ASSERT_EQ(planar.points.size(), 3u);
  EXPECT_NEAR(std::atan2(planar.points[0].y(), planar.points[0].x()), 0.01, 1e-6);
  EXPECT_NEAR(planar.points[0].norm(), 1.0 - 0.0001 / 3.0, 1e-6);
  EXPECT_NEAR(std::atan2(planar.points[1].y(), planar.points[1].x()), 0.03, 1e-6);
  EXPECT_NEAR(planar.points[2].norm(), 3.0, 1e-6);
}

TEST(LaserProjectionTest, ZeroSpacingKeepsEveryReturn) {
  ProjectionOptions options;
  options.point_spacing = 0.0;
  EXPECT_EQ(ProjectLaserScan(Fan({1.0f, 1.0f, 1.0f, 1.0f}), options).points.size(), 4u);
}

TEST(LaserProjectionTest, EveryReturnIsWithinTheSpacingOfAPoint) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> range(0.4f, 18.0f);
  std::bernoulli_distribution near_last(0.8);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<float> ranges = {range(random)};
    for (int i = 1; i < 200; ++i) {
      ranges.push_back(near_last(random) ? ranges.back() + 0.001f * range(random) : range(random));
    }
    ProjectionOptions options;
    const LaserScan scan = Fan(ranges);
    const PlanarScan merged = ProjectLaserScan(scan, options);
    options.point_spacing = 0.0;
    const PlanarScan all = ProjectLaserScan(scan, options);
    EXPECT_LT(merged.points.size(), all.points.size());
    EXPECT_EQ(merged.free_ends.size(), all.free_ends.size());
    for (const Eigen::Vector2f& point : all.points) {
      float nearest = kInf;
      for (const Eigen::Vector2f& other : merged.points) nearest = std::min(nearest, (other - point).norm());
      ASSERT_LT(nearest, 2.0f * 0.03f) << "a run's points lie within a spacing of its first, and so does its mean";
    }
  }
}

TEST(LaserProjectionTest, ValidatesItsOptions) {
  EXPECT_EQ(ProjectionOptions().Validate(), "");
  ProjectionOptions options;
  options.min_range = 15.0;
  EXPECT_NE(options.Validate().find("max_range"), std::string::npos);
  options = {};
  options.min_range = kNan;
  EXPECT_NE(options.Validate().find("min_range"), std::string::npos);
  options = {};
  options.max_bearing = 0.0;
  EXPECT_NE(options.Validate().find("max_bearing"), std::string::npos);
  options = {};
  options.point_spacing = -0.1;
  EXPECT_NE(options.Validate().find("point_spacing"), std::string::npos);
}

}  // namespace
}  // namespace arborslam
