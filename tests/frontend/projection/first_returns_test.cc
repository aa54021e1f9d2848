#include "frontend/projection/first_returns.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"
#include "frontend/projection/sweep_projection.h"

namespace arborslam {
namespace {

constexpr float kRangeMargin = 0.2f;
constexpr float kSideMargin = 0.1f;

Eigen::Vector2f Polar(double range, double bearing) {
  return Eigen::Vector2d(range * std::cos(bearing), range * std::sin(bearing)).cast<float>();
}

Sight LookAt(const PlanarScan& scan, double range, double bearing) {
  return FirstReturns(scan).Look(Polar(range, bearing), kRangeMargin, kSideMargin);
}

TEST(FirstReturnsTest, TellsWhatIsBeforeAtAndBehindAReturn) {
  for (double bearing = -kPi; bearing < kPi; bearing += 0.37) {
    PlanarScan scan;
    scan.points = {Polar(4.0, bearing), Polar(6.0, bearing)};
    EXPECT_EQ(LookAt(scan, 3.7, bearing), Sight::kFree);
    EXPECT_EQ(LookAt(scan, 3.9, bearing), Sight::kOccupied);
    EXPECT_EQ(LookAt(scan, 4.1, bearing), Sight::kOccupied);
    EXPECT_EQ(LookAt(scan, 4.3, bearing), Sight::kHidden);
    EXPECT_EQ(LookAt(scan, 6.0, bearing), Sight::kHidden);
    EXPECT_EQ(LookAt(scan, 3.0, bearing + 1.0), Sight::kUnknown);
  }
}

TEST(FirstReturnsTest, ReturnsBesideTheRayEndItToo) {
  // A return 8 cm beside the ray at this range, and something far behind it.
  PlanarScan scan;
  scan.points = {Polar(2.0, 0.04), Polar(9.0, 0.0)};
  EXPECT_EQ(LookAt(scan, 2.0, 0.0), Sight::kOccupied);
  // One 30 cm beside it does not.
  scan.points = {Polar(2.0, 0.15), Polar(9.0, 0.0)};
  EXPECT_EQ(LookAt(scan, 2.0, 0.0), Sight::kFree);
  // Across the back, where bearings wrap around.
  scan.points = {Polar(2.0, kPi - 0.02), Polar(9.0, -kPi + 0.02)};
  EXPECT_EQ(LookAt(scan, 2.0, -kPi + 0.02), Sight::kOccupied);
}

TEST(FirstReturnsTest, FreeEndsSayHowFarItIsFreeAndNothingMore) {
  PlanarScan scan;
  scan.free_ends = {Polar(5.0, 1.0)};
  EXPECT_EQ(LookAt(scan, 4.9, 1.0), Sight::kFree);
  EXPECT_EQ(LookAt(scan, 5.1, 1.0), Sight::kUnknown);
  EXPECT_EQ(LookAt(scan, 4.0, 2.0), Sight::kUnknown);
  // A return counts more than a free end that leads past it.
  scan.points = {Polar(3.0, 1.0)};
  EXPECT_EQ(LookAt(scan, 3.0, 1.0), Sight::kOccupied);
  EXPECT_EQ(LookAt(scan, 4.9, 1.0), Sight::kHidden);
}

TEST(FirstReturnsTest, ReturnsThatBecameNoPointsHideWhatIsBehind) {
  PlanarScan scan;
  scan.points = {Polar(6.0, 0.5)};
  EXPECT_EQ(LookAt(scan, 4.0, 0.5), Sight::kFree);
  scan.first_returns = {Polar(2.0, 0.5)};
  EXPECT_EQ(LookAt(scan, 4.0, 0.5), Sight::kHidden);
  EXPECT_EQ(LookAt(scan, 1.0, 0.5), Sight::kFree);
}

TEST(FirstReturnsTest, SweepsAreNotLookedThroughWhereTheyMetLeaves) {
  // A wide post behind one leaf: whether the leaf becomes a planar point or not, its ray ended there.
  std::vector<Eigen::Vector3f> points;
  std::vector<float> heights;
  const auto add = [&](double range, double bearing, float height) {
    const Eigen::Vector2f place = Polar(range, bearing);
    points.emplace_back(place.x(), place.y(), height - 0.6f);
    heights.push_back(height);
  };
  for (int column = -20; column <= 20; ++column) {
    for (const float height : {0.5f, 0.7f, 0.9f, 1.1f}) add(5.0, DegToRad(0.2 * column), height);
  }
  SweepProjection projection{SweepProjectionOptions()};
  const SweepProjection::Input input{&points, &heights, 0.6f, 2.0f, static_cast<float>(DegToRad(0.2))};
  const PlanarScan without_leaf = projection.Project(input, Eigen::Matrix3f::Identity());
  ASSERT_FALSE(without_leaf.points.empty());
  EXPECT_EQ(LookAt(without_leaf, 3.0, 0.0), Sight::kFree);
  add(2.0, 0.0, 0.8f);
  PlanarScan with_leaf = projection.Project(input, Eigen::Matrix3f::Identity());
  with_leaf.points = without_leaf.points;
  EXPECT_EQ(LookAt(with_leaf, 3.0, 0.0), Sight::kHidden);
  EXPECT_EQ(LookAt(with_leaf, 1.0, 0.0), Sight::kFree);
  EXPECT_EQ(LookAt(with_leaf, 3.0, 0.06), Sight::kFree);
}

TEST(FirstReturnsTest, AnEmptyScanKnowsNothing) {
  Random random(1);
  const FirstReturns nothing{PlanarScan()};
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2f place = Polar(random.Uniform(0.0, 20.0), random.Uniform(-kPi, kPi));
    EXPECT_EQ(nothing.Look(place, kRangeMargin, kSideMargin), Sight::kUnknown);
  }
  EXPECT_EQ(nothing.Look({0.0f, 0.0f}, kRangeMargin, kSideMargin), Sight::kUnknown);
}

TEST(FirstReturnsTest, NothingIsFreeOnOrBehindWhatWasMeasured) {
  // Whatever the margins and places: a return is never looked past in its own direction.
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    PlanarScan scan;
    for (int i = 0; i < 50; ++i) scan.points.push_back(Polar(random.Uniform(0.3, 15.0), random.Uniform(-kPi, kPi)));
    const FirstReturns first_returns(scan);
    const auto side_margin = static_cast<float>(random.Uniform(0.0, 0.5));
    for (const Eigen::Vector2f& point : scan.points) {
      const float factor = static_cast<float>(random.Uniform(1.0, 3.0));
      ASSERT_NE(first_returns.Look(point, 0.01f, side_margin), Sight::kFree);
      ASSERT_NE(first_returns.Look(point, 0.01f, side_margin), Sight::kUnknown);
      ASSERT_NE(first_returns.Look(factor * point, 0.01f, side_margin), Sight::kFree);
    }
  }
}

}  // namespace
}  // namespace arborslam
