#include "core/sensor/trajectory3.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

TEST(Trajectory3, LiftedAndSeenFromAboveIsThePlanarTrajectory) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-kPi, kPi);
  Trajectory planar;
  for (int i = 0; i < 100; ++i) planar.push_back({i * 0.5, SE2(uniform(random), uniform(random), uniform(random))});
  const Trajectory3 lifted = ToTrajectory3(planar);
  EXPECT_TRUE(lifted.has_orientation);
  const Trajectory seen = ToPlanar(lifted);
  ASSERT_EQ(seen.size(), planar.size());
  for (size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].stamp, planar[i].stamp);
    EXPECT_TRUE(seen[i].pose.IsApprox(planar[i].pose, 1e-12));
  }
}

TEST(Trajectory3, SeenFromAboveTiltDoesNotTurnTheYaw) {
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond pitch(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitX()));
  Trajectory3 tilted;
  tilted.poses.push_back({2.0, {1.0, 2.0, 3.0}, yaw * pitch * roll});
  const Trajectory seen = ToPlanar(tilted);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_TRUE(seen[0].pose.IsApprox(SE2(1.0, 2.0, 0.7), 1e-12));
}

TEST(Trajectory3, EmptyStaysEmpty) {
  EXPECT_TRUE(ToTrajectory3({}).poses.empty());
  EXPECT_TRUE(ToPlanar({}).empty());
}

TEST(Trajectory3, AnUprightLidarIsLiftedByItsHeight) {
  Tilt3 tilt;
  tilt.z = 0.7;
  const StampedPose3 lifted = Lifted({4.0, SE2(1.0, -2.0, 0.5)}, tilt);
  EXPECT_EQ(lifted.stamp, 4.0);
  EXPECT_TRUE(lifted.position.isApprox(Eigen::Vector3d(1.0, -2.0, 0.7), 1e-12));
  EXPECT_NEAR(Eigen::AngleAxisd(lifted.orientation).angle(), 0.5, 1e-12);
}

}  // namespace
}  // namespace arborslam
