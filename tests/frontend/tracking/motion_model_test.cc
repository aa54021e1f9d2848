#include "frontend/tracking/motion_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

MotionOptions WithModel(const std::string& model) {
  MotionOptions options;
  options.model = model;
  return options;
}

const char* const kModels[] = {"constant_velocity", "unicycle", "omnidirectional"};

// The pose at `t` of a robot that starts at `start` and keeps the velocity (vx, vy, omega) in its own frame.
SE2 OnArc(const SE2& start, double vx, double vy, double omega, double t) {
  const double turn = omega * t;
  if (std::abs(omega) < 1e-12) return start * SE2(vx * t, vy * t, 0.0);
  const double s = std::sin(turn) / omega;
  const double c = (1.0 - std::cos(turn)) / omega;
  return start * SE2(vx * s - vy * c, vx * c + vy * s, turn);
}

TEST(MotionModelTest, StandingStill) {
  const SE2 pose(3.0, -4.0, 2.5);
  for (const char* model : kModels) {
    EXPECT_TRUE(PredictPose({1.0, pose}, {2.0, pose}, 3.0, WithModel(model)).IsApprox(pose, 1e-12)) << model;
  }
}

TEST(MotionModelTest, StraightAhead) {
  const SE2 start(1.0, 2.0, 0.5 * kPi);
  const SE2 last = start * SE2(0.4, 0.0, 0.0);
  for (const char* model : kModels) {
    // 1.5 times the step's time.
    const SE2 predicted = PredictPose({10.0, start}, {10.2, last}, 10.5, WithModel(model));
    EXPECT_TRUE(predicted.IsApprox(last * SE2(0.6, 0.0, 0.0), 1e-9)) << model << " " << predicted;
  }
}

TEST(MotionModelTest, UnicycleFollowsItsArc) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const SE2 start(10.0 * any(random), 10.0 * any(random), kPi * any(random));
    const double speed = any(random);
    const double omega = any(random);
    const StampedPose previous{5.0, start};
    const StampedPose last{6.0, OnArc(start, speed, 0.0, omega, 1.0)};
    // The same time again: the arc's next chord, exactly.
    EXPECT_TRUE(
        PredictPose(previous, last, 7.0, WithModel("unicycle")).IsApprox(OnArc(start, speed, 0.0, omega, 2.0), 1e-9));
  }
}

TEST(MotionModelTest, OmnidirectionalFollowsItsArc) {
  std::mt19937 random(42);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const SE2 start(10.0 * any(random), 10.0 * any(random), kPi * any(random));
    const double forward = any(random);
    const double sideways = any(random);
    const double omega = any(random);
    const StampedPose previous{5.0, start};
    const StampedPose last{6.0, OnArc(start, forward, sideways, omega, 1.0)};
    EXPECT_TRUE(PredictPose(previous, last, 7.0, WithModel("omnidirectional"))
                    .IsApprox(OnArc(start, forward, sideways, omega, 2.0), 1e-9));
  }
}

TEST(MotionModelTest, UnicycleHasNoSidewaysMotion) {
  const SE2 start;
  const SE2 last(0.0, 0.3, 0.0);
  EXPECT_TRUE(PredictPose({0.0, start}, {1.0, last}, 2.0, WithModel("unicycle")).IsApprox(last, 1e-12));
  EXPECT_TRUE(
      PredictPose({0.0, start}, {1.0, last}, 2.0, WithModel("omnidirectional")).IsApprox(SE2(0.0, 0.6, 0.0), 1e-12));
}

TEST(MotionModelTest, ConstantVelocityKeepsItsDirectionInTheOdometryFrame) {
  const SE2 previous(0.0, 0.0, 0.0);
  const SE2 last(1.0, 0.5, 0.4);
  EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 2.0, WithModel("constant_velocity"))
                  .IsApprox(SE2(2.0, 1.0, 0.8), 1e-12));
}

TEST(MotionModelTest, ATurnThroughPiIsTheShortWay) {
  const SE2 previous(0.0, 0.0, kPi - 0.1);
  const SE2 last(0.0, 0.0, -kPi + 0.1);
  for (const char* model : kModels) {
    const SE2 predicted = PredictPose({0.0, previous}, {1.0, last}, 2.0, WithModel(model));
    EXPECT_NEAR(AngleDifference(predicted.theta(), -kPi + 0.3), 0.0, 1e-9) << model;
  }
}

TEST(MotionModelTest, EqualOrReversedStampsPredictTheLastPose) {
  const SE2 previous(0.0, 0.0, 0.0);
  const SE2 last(1.0, 0.5, 0.4);
  for (const char* model : kModels) {
    EXPECT_TRUE(PredictPose({1.0, previous}, {1.0, last}, 2.0, WithModel(model)).IsApprox(last, 0.0));
    EXPECT_TRUE(PredictPose({1.5, previous}, {1.0, last}, 2.0, WithModel(model)).IsApprox(last, 0.0));
    EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 1.0, WithModel(model)).IsApprox(last, 1e-12))
        << "no time has passed";
    EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 0.5, WithModel(model)).IsApprox(last, 1e-12))
        << "the robot does not walk backwards in time";
  }
}

TEST(MotionModelTest, AfterALongGapTheRobotStandsWhereItWas) {
  const SE2 previous;
  const SE2 last(0.3, 0.0, 0.0);
  for (const char* model : kModels) {
    MotionOptions options = WithModel(model);
    options.max_extrapolation = 3.0;
    EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 4.0, options).IsApprox(SE2(1.2, 0.0, 0.0), 1e-12));
    EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 4.01, options).IsApprox(last, 1e-12));
    EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 1000.0, options).IsApprox(last, 1e-12));
    options.max_extrapolation = 0.0;
    EXPECT_TRUE(PredictPose({0.0, previous}, {1.0, last}, 2.0, options).IsApprox(last, 1e-12));
  }
}

TEST(MotionModelTest, InformationIsThatOfTheSigmas) {
  const Eigen::Matrix3d expected = Eigen::Vector3d(4.0, 1.0, 100.0).asDiagonal();
  EXPECT_TRUE(MotionInformation({0.5, 1.0, 0.1}).isApprox(expected, 1e-12));
}

TEST(MotionModelTest, ValidatesItsOptions) {
  EXPECT_EQ(MotionOptions().Validate(), "");
  EXPECT_NE(WithModel("constant_velocty").Validate().find("model"), std::string::npos);
  MotionOptions options;
  options.max_extrapolation = -1.0;
  EXPECT_NE(options.Validate().find("max_extrapolation"), std::string::npos);
  options = {};
  options.translation_sigma = 0.0;
  EXPECT_NE(options.Validate().find("translation_sigma"), std::string::npos);
  options = {};
  options.rotation_sigma = -0.1;
  EXPECT_NE(options.Validate().find("rotation_sigma"), std::string::npos);
}

}  // namespace
}  // namespace arborslam
