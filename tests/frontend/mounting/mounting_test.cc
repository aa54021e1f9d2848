#include "frontend/mounting/mounting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <vector>

#include "core/simulation/random.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

using testing::HasSubstr;

TinyWorld Trees(Random* random) {
  TinyWorld world;
  world.grass = 0.05;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d place(random->Uniform(-12.0, 12.0), random->Uniform(-12.0, 12.0));
    if (place.norm() < 1.5) continue;
    world.cylinders.push_back({place, 0.1, 3.0});
    world.crowns.push_back({place, 1.0, 1.0, 2.0 + 2.0 * random->Uniform(), 1.0});
  }
  return world;
}

// Returns from the inside of a box around a lidar at the origin, within 15 deg of the horizontal.
LidarSweep SeeRoom(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double max_elevation) {
  LidarSweep sweep;
  for (int column = 0; column < 900; ++column) {
    for (int ring = 0; ring < 16; ++ring) {
      const double azimuth = 2.0 * kPi * column / 900;
      const double elevation = DegToRad(max_elevation * (ring - 7.5) / 7.5);
      const Eigen::Vector3d beam(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                                 std::sin(elevation));
      double range = 100.0;
      for (int k = 0; k < 3; ++k) range = std::min(range, (beam[k] > 0.0 ? high[k] : low[k]) / beam[k]);
      sweep.points.push_back((range * beam).cast<float>());
    }
  }
  return sweep;
}

TEST(MountingTest, IsFoundInAnyAttitude) {
  Random random(1);
  const TinyWorld world = Trees(&random);
  for (int i = 0; i < 12; ++i) {
    const double height = random.Uniform(0.3, 2.0);
    const Eigen::Isometry3d pose = LidarAt(height, random.Uniform(-180.0, 180.0), random.Uniform(-60.0, 60.0));
    const MountingEstimate mounting = EstimateMounting({SeeTinyWorld(world, pose, 0.02, &random)});
    ASSERT_TRUE(mounting.ok) << i;
    EXPECT_LT(TiltError(pose, mounting.up), 1.5) << i;
    EXPECT_NEAR(mounting.height, height, 0.08) << i;
  }
}

TEST(MountingTest, OfMostSweepsCounts) {
  Random random(2);
  const TinyWorld world = Trees(&random);
  const Eigen::Isometry3d pose = LidarAt(1.0, 60.0, 0.0);
  std::vector<LidarSweep> sweeps(3, SeeTinyWorld(world, pose, 0.02, &random));
  sweeps.push_back(SeeTinyWorld(world, LidarAt(1.0, -60.0, 0.0), 0.02, &random));
  sweeps.emplace_back();
  const MountingEstimate mounting = EstimateMounting(sweeps);
  ASSERT_TRUE(mounting.ok);
  EXPECT_EQ(mounting.num_sweeps, 5u);
  EXPECT_EQ(mounting.num_agreeing, 3u);
  EXPECT_LT(TiltError(pose, mounting.up), 1.5);
  sweeps.insert(sweeps.end(), 2, LidarSweep());
  EXPECT_FALSE(EstimateMounting(sweeps).ok);
  EXPECT_FALSE(EstimateMounting({}).ok);
}

TEST(MountingTest, AFloorIsNeitherCeilingNorWall) {
  for (const double above : {0.4, 1.2, 2.0}) {
    for (const double aside : {1.0, 2.0, 6.0}) {
      const MountingEstimate mounting =
          EstimateMounting({SeeRoom({-9.0, -aside, -above}, {14.0, 1.4 * aside, 2.4 - above}, 30.0)});
      if (!mounting.ok) continue;
      EXPECT_TRUE(IsUsualTilt(mounting.up)) << above << " " << aside << " " << mounting.up.transpose();
    }
  }
}

TEST(MountingTest, WallsAloneAreNoGround) {
  const MountingEstimate mounting = EstimateMounting({SeeRoom({-9.0, -2.0, -50.0}, {14.0, 2.0, 50.0}, 10.0)});
  EXPECT_FALSE(mounting.ok) << mounting.up.transpose();
}

TEST(MountingTest, UprightRotationIsProperAndKeepsTheHeading) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d drawn(random.Gaussian(), random.Gaussian(), random.Gaussian());
    const Eigen::Vector3f up = drawn.normalized().cast<float>();
    const Eigen::Matrix3f rotation = UprightRotation(up);
    EXPECT_NEAR(rotation.determinant(), 1.0f, 1e-5f);
    EXPECT_LT((rotation * up - Eigen::Vector3f::UnitZ()).norm(), 1e-5f);
    EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).norm(), 1e-5f);
    if (KeepsHeadingOfX(up)) {
      EXPECT_NEAR(rotation(1, 0), 0.0f, 1e-5f);
      EXPECT_GT(rotation(0, 0), 0.0f);
    } else {
      EXPECT_GT(rotation(1, 1), 0.9f);
    }
  }
  for (const float sign : {1.0f, -1.0f}) {
    EXPECT_NEAR(UprightRotation(sign * Eigen::Vector3f::UnitX()).determinant(), 1.0f, 1e-6f);
  }
  const Eigen::Vector3f left = UprightRotation(-Eigen::Vector3f::UnitZ()) * Eigen::Vector3f::UnitY();
  EXPECT_LT((left + Eigen::Vector3f::UnitY()).norm(), 1e-6f) << "upside down, what is at y is on the right";
}

TEST(MountingTest, SnapsToAxes) {
  EXPECT_EQ(SnappedToAxis(Eigen::Vector3f(0.1f, 0.05f, -1.0f).normalized()), -Eigen::Vector3f::UnitZ());
  EXPECT_EQ(SnappedToAxis(Eigen::Vector3f(0.1f, 0.99f, 0.0f).normalized()), Eigen::Vector3f::UnitY());
  const Eigen::Vector3f tilted = Eigen::Vector3f(0.3f, 0.0f, -1.0f).normalized();
  EXPECT_EQ(SnappedToAxis(tilted), tilted);
}

TEST(MountingTest, BeamsTellTheirOrigin) {
  Random random(4);
  const TinyWorld world = Trees(&random);
  const double height = 0.9;
  const LidarSweep sweep = SeeTinyWorld(world, LidarAt(height, 0.0, 0.0), 0.02, &random);
  EXPECT_FALSE(BeamOriginHeight({sweep}, static_cast<float>(height)).has_value());
  for (const float lift : {0.4f, 0.9f, 1.4f}) {
    LidarSweep moved = sweep;
    for (Eigen::Vector3f& point : moved.points) point.z() += lift;
    const std::optional<float> found = BeamOriginHeight({moved}, static_cast<float>(height) - lift);
    ASSERT_TRUE(found.has_value()) << lift;
    EXPECT_NEAR(*found, lift, 0.03f);
  }
  EXPECT_FALSE(BeamOriginHeight({}, 0.0f).has_value());
  EXPECT_FALSE(BeamOriginHeight({LidarSweep()}, 0.0f).has_value());
}

TEST(MountingTest, IsSaidInWords) {
  EXPECT_THAT(MountingText({0.0f, 0.0f, -1.0f}), HasSubstr("upside down (roll 180 deg, pitch 0 deg)"));
  EXPECT_THAT(MountingText({0.0f, 1.0f, 0.0f}), HasSubstr("on its side (roll 90 deg"));
  EXPECT_THAT(MountingText({-std::sin(0.7f), 0.0f, std::cos(0.7f)}), HasSubstr("tilted (roll 0 deg, pitch 40 deg)"));
}

}  // namespace
}  // namespace arborslam
