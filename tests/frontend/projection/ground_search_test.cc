#include "frontend/projection/ground_search.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/simulation/random.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

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

TEST(GroundSearchTest, FindsTheGroundInAnyAttitude) {
  Random random(1);
  const TinyWorld world = Trees(&random);
  for (int i = 0; i < 12; ++i) {
    const double height = random.Uniform(0.3, 2.0);
    const Eigen::Isometry3d pose = LidarAt(height, random.Uniform(-180.0, 180.0), random.Uniform(-60.0, 60.0));
    const GroundPlane ground = SearchGround(SeeTinyWorld(world, pose, 0.02, &random).points, GroundSearchRegion());
    ASSERT_TRUE(ground.ok) << i;
    EXPECT_LT(TiltError(pose, ground.normal), 1.5) << i;
    EXPECT_NEAR(ground.height, height, 0.08) << i;
  }
}

TEST(GroundSearchTest, StandsATenthOfReturnsBelow) {
  Random random(2);
  const TinyWorld world = Trees(&random);
  for (const bool mirrored : {true, false}) {
    const Eigen::Isometry3d pose = LidarAt(0.8, 5.0, -8.0);
    std::vector<Eigen::Vector3f> points = SeeTinyWorld(world, pose, 0.02, &random).points;
    for (Eigen::Vector3f& point : points) {
      if (random.Uniform() > 0.1) continue;
      Eigen::Vector3d p = pose * point.cast<double>();
      p.z() = mirrored ? -p.z() : -3.0 * random.Uniform();
      point = (pose.inverse() * p).cast<float>();
    }
    const GroundPlane ground = SearchGround(points, GroundSearchRegion());
    ASSERT_TRUE(ground.ok) << mirrored;
    EXPECT_LT(TiltError(pose, ground.normal), 1.0) << mirrored;
    EXPECT_NEAR(ground.height, 0.8, 0.08) << mirrored;
  }
}

TEST(GroundSearchTest, KeepsToItsRegion) {
  Random random(3);
  const Eigen::Isometry3d pose = LidarAt(0.8, 40.0, 0.0);
  const LidarSweep sweep = SeeTinyWorld(Trees(&random), pose, 0.02, &random);
  GroundSearchRegion region;
  region.max_tilt = 0.5f;
  const GroundPlane upright = SearchGround(sweep.points, region);
  EXPECT_TRUE(upright.score == 0.0f || upright.normal.z() >= std::cos(0.5f) - 1e-5f);
  region.max_tilt = 3.2f;
  region.min_height = 1.0f;
  const GroundPlane lower = SearchGround(sweep.points, region);
  EXPECT_TRUE(lower.score == 0.0f || lower.height >= 1.0f);
  region = GroundSearchRegion();
  region.up = (pose.linear().transpose() * Eigen::Vector3d::UnitZ()).cast<float>();
  region.min_tilt = 0.7f;
  EXPECT_LT(SearchGround(sweep.points, region).score, 0.5f * SearchGround(sweep.points, {}).score);
}

TEST(GroundSearchTest, StandsDegenerateInput) {
  EXPECT_FALSE(SearchGround({}, GroundSearchRegion()).ok);
  for (const size_t size : {1, 3, 1000}) {
    EXPECT_FALSE(SearchGround(std::vector<Eigen::Vector3f>(size, {1.0f, 2.0f, -0.5f}), GroundSearchRegion()).ok);
  }
  std::vector<Eigen::Vector3f> line;
  std::vector<Eigen::Vector3f> ring;
  for (int i = 0; i < 2000; ++i) {
    line.emplace_back(0.01f * static_cast<float>(i) - 10.0f, 2.0f, -0.5f);
    const float bearing = 0.00314f * static_cast<float>(i);
    const float range = 4.0f + 2.0f * std::sin(5.0f * bearing);
    ring.emplace_back(range * std::cos(bearing), range * std::sin(bearing), 0.0f);
  }
  EXPECT_FALSE(SearchGround(line, GroundSearchRegion()).ok);
  GroundSearchRegion region;
  region.min_height = -1.0f;
  EXPECT_FALSE(SearchGround(ring, region).ok) << "a lidar of one ring";
}

}  // namespace
}  // namespace arborslam
