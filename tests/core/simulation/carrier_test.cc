#include "core/simulation/carrier.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

const Eigen::Vector2d kLow(-30.0, -30.0);
const Eigen::Vector2d kHigh(40.0, 40.0);

ClosedPath Loop() { return ClosedPath({{0.0, 0.0}, {12.0, 0.0}, {12.0, 8.0}, {-4.0, 8.0}, {-4.0, 0.0}}, 1.0); }

UnevenGround Waves(double undulation, double slope = 0.0) {
  UnevenGroundOptions options;
  options.undulation = undulation;
  options.slope = slope;
  options.slope_direction = 20.0;
  return UnevenGround(options, 1, kLow, kHigh);
}

TEST(CarrierTest, RestsGoesAroundAndRests) {
  const UnevenGround terrain = Waves(0.3);
  CarrierOptions options;
  const Carrier carrier(options, Loop(), &terrain, 1);
  EXPECT_NEAR(carrier.Duration(), Loop().Length() + 4.0, 1e-9);
  EXPECT_EQ(carrier.DistanceAt(0.0), 0.0);
  EXPECT_EQ(carrier.DistanceAt(-5.0), 0.0);
  EXPECT_EQ(carrier.DistanceAt(0.9), 0.0);
  EXPECT_NEAR(carrier.DistanceAt(carrier.Duration() - 0.5), Loop().Length(), 1e-9);
  EXPECT_NEAR(carrier.DistanceAt(carrier.Duration() + 50.0), Loop().Length(), 1e-9);
  double before = 0.0;
  for (double time = 0.0; time < carrier.Duration(); time += 0.01) {
    const double distance = carrier.DistanceAt(time);
    ASSERT_GE(distance, before - 1e-9) << time;
    ASSERT_LT(distance - before, 0.013) << time;
    before = distance;
  }
  const Eigen::Vector3d begin = carrier.PoseAt(0.0).translation();
  const Eigen::Vector3d end = carrier.PoseAt(carrier.Duration()).translation();
  EXPECT_LT((end - begin).norm(), 0.02);
  EXPECT_LT(begin.head<2>().norm(), 0.02);
}

TEST(CarrierTest, PosesAreSmooth) {
  const UnevenGround terrain = Waves(0.4);
  for (const std::string& motion : BodyMotion::Kinds()) {
    CarrierOptions options;
    options.motion = motion;
    const Carrier carrier(options, Loop(), &terrain, 5);
    constexpr double kStep = 1e-3;
    for (double time = kStep; time < carrier.Duration(); time += 0.0173) {
      const Eigen::Isometry3d before = carrier.PoseAt(time - kStep);
      const Eigen::Isometry3d here = carrier.PoseAt(time);
      const Eigen::Isometry3d after = carrier.PoseAt(time + kStep);
      const Eigen::Vector3d acceleration =
          (after.translation() - 2.0 * here.translation() + before.translation()) / (kStep * kStep);
      ASSERT_LT(acceleration.norm(), 25.0) << motion << " " << time;
      const Eigen::AngleAxisd turn(Eigen::Matrix3d(here.linear().transpose() * after.linear()));
      const Eigen::AngleAxisd turn_before(Eigen::Matrix3d(before.linear().transpose() * here.linear()));
      const Eigen::Vector3d rate = turn.angle() / kStep * turn.axis();
      const Eigen::Vector3d rate_before = turn_before.angle() / kStep * turn_before.axis();
      ASSERT_LT(rate.norm(), 2.5) << motion << " " << time;
      ASSERT_LT((rate - rate_before).norm() / kStep, 80.0) << motion << " " << time;
    }
  }
}

TEST(CarrierTest, StandsOnTheGroundAndTiltsWithIt) {
  const UnevenGround terrain = Waves(0.4, 8.0);
  CarrierOptions options;
  options.restlessness = 0.0;
  options.sensor_height = 0.7;
  const Carrier follows(options, Loop(), &terrain, 5);
  options.ground_following = 0.0;
  const Carrier level(options, Loop(), &terrain, 5);
  for (double time = 0.0; time < level.Duration(); time += 0.31) {
    const Eigen::Isometry3d pose = level.PoseAt(time);
    EXPECT_NEAR(pose.translation().z(), terrain.SmoothHeight(pose.translation().head<2>()) + 0.7, 1e-9);
    EXPECT_NEAR(pose.linear()(2, 2), 1.0, 1e-12);
    // With the ground: the sensor's z axis is its normal.
    const Eigen::Isometry3d tilted = follows.PoseAt(time);
    const Eigen::Vector2d foot = pose.translation().head<2>();
    const Eigen::Vector2d gradient = terrain.SmoothGradient(foot);
    const Eigen::Vector3d normal = Eigen::Vector3d(-gradient.x(), -gradient.y(), 1.0).normalized();
    EXPECT_GT(normal.dot(tilted.linear().col(2)), std::cos(DegToRad(0.3))) << time;
    EXPECT_LT((tilted.translation() - pose.translation()).norm(), 0.7 * std::tan(DegToRad(16.0)));
  }
}

TEST(CarrierTest, VelocityIsThatOfTheMeanCourse) {
  const UnevenGround terrain = Waves(0.0);
  CarrierOptions options;
  options.restlessness = 0.0;
  options.wander = 0.0;
  const Carrier carrier(options, Loop(), &terrain, 5);
  double distance = 0.0;
  double turn = 0.0;
  constexpr double kStep = 0.01;
  for (double time = 0.0; time < carrier.Duration(); time += kStep) {
    const OdometryVelocity velocity = carrier.VelocityAt(time);
    ASSERT_LT(std::abs(velocity.left), 0.03);
    distance += kStep * velocity.forward;
    turn += kStep * velocity.yaw;
  }
  EXPECT_NEAR(distance, Loop().Length(), 0.02 * Loop().Length());
  EXPECT_NEAR(turn, 2.0 * kPi, 0.01);
  const OdometryVelocity rest = carrier.VelocityAt(0.5);
  EXPECT_EQ(rest.forward, 0.0);
  EXPECT_EQ(rest.yaw, 0.0);
}

TEST(CarrierOptionsTest, RefusesWhatCannotBe) {
  EXPECT_EQ(CarrierOptions().Validate(), "");
  const auto problem = [](auto change) {
    CarrierOptions options;
    change(&options);
    return options.Validate();
  };
  EXPECT_EQ(problem([](CarrierOptions* o) { o->motion = "hover"; }),
            "motion is 'hover', must be wheeled, trot or handheld");
  EXPECT_NE(problem([](CarrierOptions* o) { o->speed = 0.0; }), "");
  EXPECT_NE(problem([](CarrierOptions* o) { o->sensor_height = 0.0; }), "");
  EXPECT_NE(problem([](CarrierOptions* o) { o->turn_radius = 0.0; }), "");
  EXPECT_NE(problem([](CarrierOptions* o) { o->wander = -1.0; }), "");
  EXPECT_NE(problem([](CarrierOptions* o) { o->restlessness = 6.0; }), "");
  EXPECT_NE(problem([](CarrierOptions* o) { o->ground_following = 1.5; }), "");
}

}  // namespace
}  // namespace arborslam
