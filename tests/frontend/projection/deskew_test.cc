#include "frontend/projection/deskew.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

// T_middle_lidar, `time` after the middle, of a lidar that moves with a constant twist: by many small steps.
Eigen::Isometry3d Move(const SweepMotion& motion, double time) {
  constexpr int kSteps = 4000;
  const double dt = time / kSteps;
  const Eigen::Vector3d turn = dt * motion.angular_velocity.cast<double>();
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  if (turn.norm() > 0.0) step.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  // The middle of the step's own arc.
  step.translation() = dt * motion.velocity.cast<double>() + 0.5 * dt * turn.cross(motion.velocity.cast<double>());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kSteps; ++i) pose = pose * step;
  return pose;
}

TEST(DeskewTest, UndoesAConstantTwist) {
  Random random(1);
  for (const double rate : {0.0, 0.5, 2.0, 6.0}) {
    SweepMotion motion;
    for (int axis = 0; axis < 3; ++axis) {
      motion.velocity[axis] = static_cast<float>(random.Uniform(-3.0, 3.0));
      motion.angular_velocity[axis] = static_cast<float>(rate * random.Uniform(-1.0, 1.0));
    }
    LidarSweep sweep;
    sweep.duration = 0.1;
    std::vector<float> phases;
    std::vector<Eigen::Vector3f> expected;
    for (int i = 0; i < 70; ++i) {
      const float phase = i == 0 ? 0.0f : (i == 1 ? 1.0f : static_cast<float>(random.Uniform()));
      const Eigen::Vector3d point(random.Uniform(-20.0, 20.0), random.Uniform(-20.0, 20.0), random.Uniform(-2.0, 5.0));
      phases.push_back(phase);
      expected.push_back(point.cast<float>());
      sweep.points.push_back((Move(motion, (phase - 0.5) * sweep.duration).inverse() * point).cast<float>());
    }
    const std::vector<Eigen::Vector3f> points = Deskew(sweep, phases, motion);
    ASSERT_EQ(points.size(), expected.size());
    for (size_t i = 0; i < points.size(); ++i) {
      // Rounding, and |w|^5 / 120 of the range.
      EXPECT_LT((points[i] - expected[i]).norm(), 2e-5f + (rate > 2.0 ? 1e-3f : 0.0f)) << "rate " << rate;
    }
  }
}

TEST(DeskewTest, LeavesTheMiddleWhereItIs) {
  LidarSweep sweep;
  sweep.duration = 0.1;
  sweep.points = {{3.0f, -2.0f, 1.0f}};
  const SweepMotion motion{{5.0f, 4.0f, 3.0f}, {1.0f, 2.0f, 3.0f}};
  EXPECT_EQ(Deskew(sweep, {0.5f}, motion)[0], sweep.points[0]);
}

TEST(DeskewTest, WithoutPhasesNothingMoves) {
  LidarSweep sweep;
  sweep.duration = 0.1;
  sweep.points = {{3.0f, -2.0f, 1.0f}, {1.0f, 1.0f, 1.0f}};
  const SweepMotion motion{{5.0f, 4.0f, 3.0f}, {1.0f, 2.0f, 3.0f}};
  EXPECT_EQ(Deskew(sweep, {}, motion), sweep.points);
  EXPECT_EQ(Deskew(sweep, {0.0f, 1.0f}, SweepMotion()), sweep.points);
  EXPECT_TRUE(Deskew(LidarSweep(), {}, motion).empty());
}

}  // namespace
}  // namespace arborslam
