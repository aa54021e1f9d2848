#include "frontend/tracking/sweep_reducer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/simulation/random.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

LidarSweep SweepAmongTrunks() {
  Random random(4);
  TinyWorld world;
  for (int i = -3; i <= 3; ++i) {
    world.cylinders.push_back({{2.1 * i + 0.3, 2.2}, 0.1, 1.5});
    world.cylinders.push_back({{1.9 * i - 0.2, -2.6}, 0.12, 1.5});
  }
  LidarSweep sweep = SeeTinyWorld(world, LidarAt(0.5, 0.0, 0.0), 0.005, &random);
  sweep.start = 2.0;
  return sweep;
}

SweepReducer MakeReducer(const ReductionOptions& options) {
  return SweepReducer(options, SweepProjectionOptions(), MovingObjectOptions(), CompactThingOptions(), 0.5);
}

// Share of `points` that have one of `others` within 1 cm.
double ShareMet(const std::vector<Eigen::Vector2f>& points, const std::vector<Eigen::Vector2f>& others) {
  const auto is_met = [&](const Eigen::Vector2f& point) {
    return std::any_of(others.begin(), others.end(),
                       [&](const Eigen::Vector2f& other) { return (other - point).norm() < 0.01f; });
  };
  return static_cast<double>(std::count_if(points.begin(), points.end(), is_met)) / static_cast<double>(points.size());
}

const PlanarVelocity kVelocity{{0.7, -0.3}, 0.5};

TEST(SweepReducerTest, DeskewingAgainIsDeskewingWithTheRightVelocity) {
  const LidarSweep sweep = SweepAmongTrunks();
  SweepReducer reducer = MakeReducer(ReductionOptions());
  const ReducedSweep expected = reducer.Reduce(sweep, SE2(), kVelocity);
  ReducedSweep reduced = reducer.Reduce(sweep, SE2(), PlanarVelocity());
  ASSERT_GT(reduced.planar.points.size(), 50u);
  EXPECT_LT(ShareMet(reduced.planar.points, expected.planar.points), 0.7);
  reducer.Redeskew(sweep, kVelocity, &reduced);
  EXPECT_GT(ShareMet(reduced.planar.points, expected.planar.points), 0.95);
  EXPECT_GT(ShareMet(reduced.with_moving.points, expected.with_moving.points), 0.95);
  EXPECT_GT(ShareMet(reduced.to_match, expected.to_match), 0.95);
  EXPECT_EQ(reduced.deskewing.linear, kVelocity.linear);
  EXPECT_EQ(reduced.deskewing.angular, kVelocity.angular);
}

TEST(SweepReducerTest, CannotDeskewAgainWithoutDeskewing) {
  ReductionOptions options;
  const LidarSweep sweep = SweepAmongTrunks();
  SweepReducer reducer = MakeReducer(options);
  EXPECT_TRUE(reducer.CanRedeskew(reducer.Reduce(sweep, SE2(), kVelocity)));
  options.deskew = false;
  reducer = MakeReducer(options);
  EXPECT_FALSE(reducer.CanRedeskew(reducer.Reduce(sweep, SE2(), kVelocity)));
}

// Without an order in which points came, nobody knows when.
TEST(SweepReducerTest, CannotDeskewAgainWithoutTiming) {
  LidarSweep sweep = SweepAmongTrunks();
  sweep.duration = 0.0;
  SweepReducer reducer = MakeReducer(ReductionOptions());
  const ReducedSweep reduced = reducer.Reduce(sweep, SE2(), PlanarVelocity());
  ASSERT_TRUE(reduced.planar.phases.empty());
  EXPECT_FALSE(reducer.CanRedeskew(reduced));
}

TEST(SweepReducerTest, TakesAnEmptySweep) {
  LidarSweep sweep;
  sweep.duration = 0.1;
  SweepReducer reducer = MakeReducer(ReductionOptions());
  const ReducedSweep reduced = reducer.Reduce(sweep, SE2(), PlanarVelocity());
  EXPECT_FALSE(reducer.CanRedeskew(reduced));
  EXPECT_TRUE(reduced.planar.points.empty());
  EXPECT_TRUE(reduced.to_match.empty());
}

}  // namespace
}  // namespace arborslam
