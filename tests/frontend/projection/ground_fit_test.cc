#include "frontend/projection/ground_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/simulation/random.h"
#include "frontend/projection/lowest_returns.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

GroundFit Fit(const LidarSweep& sweep, const GroundFit& prior = {}) {
  LowestReturns lowest(0.5f, 0.5f, 18.0f);
  return FitGround(lowest.Find(sweep.points, prior.normal), prior);
}

// Trees, a leaf wall, and two people close by.
TinyWorld Orchard() {
  TinyWorld world;
  for (int row = -1; row <= 1; row += 2) {
    for (int i = -4; i <= 4; ++i) {
      world.cylinders.push_back({{2.5 * i + 0.4, 2.0 * row}, 0.1, 1.5});
      world.crowns.push_back({{2.5 * i + 0.4, 2.0 * row}, 0.9, 0.7, 3.0, 1.2});
    }
  }
  for (int i = -10; i <= 10; ++i) world.crowns.push_back({{0.5 * i, 4.5}, 0.3, 0.0, 1.8, 4.0});
  world.cylinders.push_back({{-1.2, 0.3}, 0.2, 1.8});
  world.cylinders.push_back({{-1.5, -0.5}, 0.2, 1.7});
  return world;
}

TEST(GroundFitTest, FindsALevelPlaneAtAnyHeight) {
  Random random(1);
  for (const double height : {0.2, 0.5, 1.0, 2.0, 3.0}) {
    const Eigen::Isometry3d pose = LidarAt(height, 2.0, -3.0);
    const GroundFit fit = Fit(SeeTinyWorld({}, pose, 0.02, &random));
    ASSERT_TRUE(fit.ok) << height;
    EXPECT_LT(TiltError(pose, fit.normal), 0.3) << height;
    EXPECT_NEAR(fit.height, height, 0.03) << height;
    EXPECT_LT(fit.rms, 0.03f);
  }
}

TEST(GroundFitTest, StandsOutliersAndGrass) {
  Random random(2);
  TinyWorld world = Orchard();
  world.grass = 0.2;
  for (const double height : {0.5, 0.9, 1.6}) {
    const Eigen::Isometry3d pose = LidarAt(height, -2.0, 1.0);
    const GroundFit fit = Fit(SeeTinyWorld(world, pose, 0.02, &random));
    ASSERT_TRUE(fit.ok) << height;
    EXPECT_LT(TiltError(pose, fit.normal), 0.7) << height;
    EXPECT_NEAR(fit.height, height, 0.1) << height;
  }
}

TEST(GroundFitTest, FollowsSlopes) {
  Random random(3);
  for (const double slope : {5.0, 10.0, 15.0}) {
    TinyWorld world = Orchard();
    const double rise = std::tan(DegToRad(slope));
    world.ground = [rise](const Eigen::Vector2d& place) { return rise * place.x(); };
    for (TinyWorld::Cylinder& cylinder : world.cylinders) cylinder.height += rise * cylinder.place.x();
    for (TinyWorld::Crown& crown : world.crowns) {
      crown.bottom += rise * crown.place.x();
      crown.top += rise * crown.place.x();
    }
    const Eigen::Vector3d up = Eigen::Vector3d(-rise, 0.0, 1.0).normalized();
    // A body that follows the slope, and one that stays level.
    for (const double follows : {1.0, 0.0}) {
      const Eigen::Isometry3d pose = LidarAt(0.6, 1.0, -follows * slope);
      const GroundFit fit = Fit(SeeTinyWorld(world, pose, 0.02, &random));
      ASSERT_TRUE(fit.ok) << slope;
      EXPECT_LT(TiltError(pose, fit.normal, up), 0.5) << slope;
      EXPECT_NEAR(fit.height, 0.6 * up.z(), 0.05) << slope;
    }
  }
}

TEST(GroundFitTest, StaysLevelUnderImpulses) {
  Random random(4);
  TinyWorld world = Orchard();
  world.grass = 0.05;
  GroundFit prior;
  double squared = 0.0;
  constexpr int kSweeps = 40;
  for (int i = 0; i < kSweeps; ++i) {
    const Eigen::Isometry3d pose =
        LidarAt(0.5 + random.Uniform(-0.03, 0.03), random.Uniform(-3.0, 3.0), random.Uniform(-3.0, 3.0));
    const GroundFit fit = Fit(SeeTinyWorld(world, pose, 0.02, &random), prior);
    ASSERT_TRUE(fit.ok) << i;
    const double error = TiltError(pose, fit.normal);
    EXPECT_LT(error, 0.5) << i;
    EXPECT_NEAR(fit.height, pose.translation().z(), 0.05) << i;
    squared += error * error;
    prior = fit;
  }
  EXPECT_LT(std::sqrt(squared / kSweeps), 0.3);
}

TEST(GroundFitTest, StandsUndulation) {
  Random random(5);
  TinyWorld world = Orchard();
  world.ground = [](const Eigen::Vector2d& place) {
    return 0.2 * std::sin(2.0 * kPi * place.x() / 15.0) * std::cos(2.0 * kPi * place.y() / 20.0);
  };
  GroundFit prior;
  for (int i = 0; i < 8; ++i) {
    Eigen::Isometry3d pose = LidarAt(0.0, random.Uniform(-3.0, 3.0), random.Uniform(-3.0, 3.0));
    pose.translation().x() = 1.0 * i - 4.0;
    pose.translation().z() = 0.5 + world.ground(pose.translation().head<2>());
    // The mean slope of the ground around the robot.
    const double h = 3.0;
    const double x = pose.translation().x();
    const double slope = (world.ground({x + h, 0.0}) - world.ground({x - h, 0.0})) / (2.0 * h);
    const GroundFit fit = Fit(SeeTinyWorld(world, pose, 0.02, &random), prior);
    ASSERT_TRUE(fit.ok);
    EXPECT_LT(TiltError(pose, fit.normal, Eigen::Vector3d(-slope, 0.0, 1.0).normalized()), 2.0) << i;
    // A plane cuts off the hilltops and fills the hollows.
    EXPECT_NEAR(fit.height, 0.5, 0.2) << i;
    prior = fit;
  }
}

TEST(GroundFitTest, IsNotTrappedByAWrongPrior) {
  Random random(6);
  const Eigen::Isometry3d pose = LidarAt(0.5, 2.0, 1.0);
  const LidarSweep sweep = SeeTinyWorld(Orchard(), pose, 0.02, &random);
  for (const float height : {0.15f, 1.2f, 3.0f}) {
    for (const double tilt : {-15.0, 0.0, 12.0}) {
      GroundFit prior;
      prior.ok = true;
      prior.height = height;
      prior.normal = LidarAt(0.0, tilt, 0.5 * tilt).linear().row(2).transpose().cast<float>();
      const GroundFit fit = Fit(sweep, prior);
      ASSERT_TRUE(fit.ok);
      EXPECT_LT(TiltError(pose, fit.normal), 0.5) << height << " " << tilt;
      EXPECT_NEAR(fit.height, 0.5, 0.05) << height << " " << tilt;
    }
  }
}

TEST(GroundFitTest, SaysWhenThereIsNoGround) {
  EXPECT_FALSE(Fit(LidarSweep()).ok);
  Random random(7);
  // So high that no ring reaches the ground, between trunks.
  TinyWorld forest;
  forest.ground = [](const Eigen::Vector2d&) { return -1000.0; };
  for (int i = 0; i < 60; ++i) {
    forest.cylinders.push_back({{random.Uniform(-15.0, 15.0), random.Uniform(-15.0, 15.0)}, 0.15, 30.0});
  }
  EXPECT_FALSE(Fit(SeeTinyWorld(forest, LidarAt(1.0, 0.0, 0.0), 0.02, &random)).ok);
  // A wall on one side.
  std::vector<Eigen::Vector3f> wall;
  for (int i = -20; i <= 20; ++i) wall.emplace_back(0.3f * static_cast<float>(i), 2.0f, -0.5f);
  EXPECT_FALSE(FitGround(wall, GroundFit()).ok);
}

TEST(GroundFitTest, StandsDegenerateInput) {
  for (const size_t size : {1, 2, 3, 30}) {
    EXPECT_FALSE(FitGround(std::vector<Eigen::Vector3f>(size, {1.0f, 2.0f, -0.5f}), GroundFit()).ok) << size;
  }
}

}  // namespace
}  // namespace arborslam
