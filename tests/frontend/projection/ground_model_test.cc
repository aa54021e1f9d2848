#include "frontend/projection/ground_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/simulation/random.h"
#include "frontend/projection/lowest_returns.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

struct Modelled {
  LidarSweep sweep;
  GroundFit fit;
  GroundModel model;
  std::vector<float> heights;
};

Modelled Model(const TinyWorld& world, const Eigen::Isometry3d& pose, double noise) {
  Random random(1);
  Modelled modelled;
  modelled.sweep = SeeTinyWorld(world, pose, noise, &random);
  LowestReturns lowest(0.5f, 0.5f, GroundModel::kReach);
  lowest.Find(modelled.sweep.points, Eigen::Vector3f::UnitZ());
  modelled.fit = FitGround(lowest.returns(), GroundFit());
  EXPECT_TRUE(modelled.fit.ok);
  modelled.model.Build(lowest.returns(), modelled.fit);
  modelled.model.Measure(modelled.sweep.points, &modelled.heights);
  return modelled;
}

TEST(LevelRotationTest, TurnsUprightAndKeepsTheHeading) {
  const Eigen::Vector3f normal = Eigen::Vector3f(0.1f, -0.3f, 0.9f).normalized();
  const Eigen::Matrix3f rotation = LevelRotation(normal);
  EXPECT_TRUE((rotation * rotation.transpose()).isIdentity(1e-6f));
  EXPECT_NEAR(rotation.determinant(), 1.0f, 1e-6f);
  EXPECT_TRUE((rotation * normal).isApprox(Eigen::Vector3f::UnitZ(), 1e-6f));
  const Eigen::Vector3f ahead = rotation * Eigen::Vector3f::UnitX();
  EXPECT_NEAR(ahead.y(), 0.0f, 1e-6f);
  EXPECT_GT(ahead.x(), 0.0f);
  EXPECT_TRUE(LevelRotation(Eigen::Vector3f::UnitZ()).isIdentity(1e-6f));
}

TEST(GroundModelTest, FollowsUndulation) {
  TinyWorld world;
  world.ground = [](const Eigen::Vector2d& place) { return 0.2 * std::sin(2.0 * kPi * (place.x() + 3.0) / 15.0); };
  Eigen::Isometry3d pose = LidarAt(0.7 + world.ground({0.0, 0.0}), 2.0, -1.0);
  const Modelled modelled = Model(world, pose, 0.01);
  // All returns are ground.
  std::vector<float> off;
  for (size_t i = 0; i < modelled.heights.size(); ++i) {
    if (modelled.sweep.points[i].norm() < 12.0f) off.push_back(std::abs(modelled.heights[i]));
  }
  ASSERT_GT(off.size(), 1000u);
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() / 2], 0.04f);
  EXPECT_LT(off[off.size() * 99 / 100], 0.15f);
  // Under the lidar, where nothing is seen.
  EXPECT_NEAR(modelled.fit.height - modelled.model.HeightAt(0.0f, 0.0f), 0.7, 0.12);
}

TEST(GroundModelTest, SamplesLieOnTheGround) {
  TinyWorld world;
  world.ground = [](const Eigen::Vector2d& place) { return 0.1 * place.x() + 0.02 * place.y(); };
  for (int i = 0; i < 12; ++i) world.cylinders.push_back({{1.5 * i - 9.0, 2.0}, 0.1, 3.0});
  const Eigen::Isometry3d pose = LidarAt(0.6, -3.0, 2.0);
  const Modelled modelled = Model(world, pose, 0.02);
  ASSERT_GT(modelled.model.samples().size(), 30u);
  double mean = 0.0;
  double num_off = 0.0;
  const auto num_samples = static_cast<double>(modelled.model.samples().size());
  for (const GroundSample& sample : modelled.model.samples()) {
    const Eigen::Vector3d p = pose * sample.position.cast<double>();
    const double above = p.z() - world.ground(p.head<2>());
    EXPECT_GE(sample.weight, 1.0f);
    EXPECT_NEAR(above, 0.0, 0.15);
    num_off += std::abs(above) > 0.05 ? 1.0 : 0.0;
    mean += above / num_samples;
  }
  // A trunk's foot may stand for the ground that it hides.
  EXPECT_LE(num_off, 0.01 * num_samples);
  EXPECT_NEAR(mean, 0.0, 0.01);
}

TEST(GroundModelTest, LiesUnderHedgesAndBushes) {
  TinyWorld world;
  // Walls that hide their ground and what is behind.
  for (int i = -20; i <= 20; ++i) {
    for (const double y : {-1.6, 1.6}) world.crowns.push_back({{0.5 * i, y}, 0.4, 0.15, 2.0, 8.0});
  }
  const Modelled modelled = Model(world, LidarAt(0.9, 0.0, 0.0), 0.02);
  for (float x = -6.0f; x <= 6.0f; x += 0.5f) {
    for (float y = -4.0f; y <= 4.0f; y += 0.5f) {
      EXPECT_NEAR(modelled.model.HeightAt(x, y) - modelled.fit.height, -0.9f, 0.12f) << x << " " << y;
    }
  }
}

TEST(GroundModelTest, TakesReturnsJustBelowTheBorderOfItsReach) {
  GroundFit fit;
  fit.ok = true;
  fit.normal = Eigen::Vector3f::UnitZ();
  fit.height = 0.7f;
  GroundModel model;
  model.Build({}, fit);
  // Of these the distance from the opposite border is rounded up to twice the reach.
  const float border = std::nextafter(GroundModel::kReach, 0.0f);
  ASSERT_EQ(border + GroundModel::kReach, 2.0f * GroundModel::kReach);
  std::vector<Eigen::Vector3f> points(20, Eigen::Vector3f(border, border, -fit.height));
  points.insert(points.end(), 20, Eigen::Vector3f(0.0f, border, -fit.height));
  std::vector<float> heights;
  model.Measure(points, &heights);
  ASSERT_EQ(model.samples().size(), 2u);
  for (const GroundSample& sample : model.samples()) EXPECT_NEAR(sample.position.y(), border, 1e-4f);
}

TEST(GroundModelTest, WithoutReturnsIsThePlane) {
  GroundModel model;
  GroundFit fit;
  fit.height = 0.5f;
  fit.normal = Eigen::Vector3f(0.1f, 0.0f, 1.0f).normalized();
  model.Build({}, fit);
  EXPECT_EQ(model.HeightAt(3.0f, -2.0f), 0.0f);
  EXPECT_EQ(model.HeightAt(300.0f, -200.0f), 0.0f);
  std::vector<float> heights(5);
  model.Measure({}, &heights);
  EXPECT_TRUE(heights.empty());
  EXPECT_TRUE(model.samples().empty());
  model.Measure({fit.normal}, &heights);
  ASSERT_EQ(heights.size(), 1u);
  EXPECT_NEAR(heights[0], 1.5f, 1e-6f);
}

}  // namespace
}  // namespace arborslam
