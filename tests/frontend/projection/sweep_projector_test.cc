#include "frontend/projection/sweep_projector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/simulation/random.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

TinyWorld Orchard() {
  TinyWorld world;
  world.grass = 0.08;
  for (int row = -1; row <= 1; row += 2) {
    for (int i = -4; i <= 4; ++i) {
      world.cylinders.push_back({{2.5 * i + 0.4, 2.0 * row}, 0.1, 1.4});
      world.crowns.push_back({{2.5 * i + 0.4, 2.0 * row}, 0.9, 1.2, 3.0, 1.2});
    }
  }
  return world;
}

// Distance [m] from a point to the bark of the nearest trunk.
double ToTrunk(const TinyWorld& world, const Eigen::Vector2d& point) {
  double nearest = 1e9;
  for (const TinyWorld::Cylinder& cylinder : world.cylinders) {
    nearest = std::min(nearest, std::abs((point - cylinder.place).norm() - cylinder.radius));
  }
  return nearest;
}

TEST(SweepProjectorTest, LeavesTrunksOfAnOrchardUnderImpulses) {
  Random random(1);
  const TinyWorld world = Orchard();
  SweepProjector projector((SweepProjectionOptions()));
  PreparedSweep prepared;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Isometry3d pose = LidarAt(0.5, random.Uniform(-3.0, 3.0), random.Uniform(-3.0, 3.0));
    LidarSweep sweep = SeeTinyWorld(world, pose, 0.02, &random);
    sweep.start = 3.0;
    prepared = projector.Prepare(sweep, SweepMotion(), std::move(prepared));
    EXPECT_TRUE(prepared.fit.ok);
    EXPECT_EQ(prepared.stamp, 3.05);
    EXPECT_LT(TiltError(pose, prepared.ground.normal), 0.5);
    EXPECT_NEAR(prepared.lidar_height, 0.5, 0.06);
    EXPECT_NEAR(prepared.column_width, DegToRad(0.4), 1e-4);
    EXPECT_EQ(prepared.points.size(), sweep.points.size());
    EXPECT_EQ(prepared.heights.size(), sweep.points.size());
    EXPECT_EQ(prepared.phases.size(), sweep.points.size());
    EXPECT_FALSE(prepared.samples.empty());

    const PlanarScan scan = projector.Project(prepared, LevelRotation(prepared.ground.normal));
    EXPECT_EQ(scan.stamp, 3.05);
    ASSERT_GT(scan.points.size(), 30u);
    size_t num_near = 0;
    std::vector<bool> seen(world.cylinders.size(), false);
    for (const Eigen::Vector2f& point : scan.points) {
      num_near += ToTrunk(world, point.cast<double>()) < 0.08 ? 1 : 0;
      for (size_t k = 0; k < seen.size(); ++k) {
        seen[k] = seen[k] || (point.cast<double>() - world.cylinders[k].place).norm() < 0.2;
      }
    }
    EXPECT_GT(static_cast<double>(num_near), 0.85 * static_cast<double>(scan.points.size()));
    for (size_t k = 0; k < seen.size(); ++k) {
      if (world.cylinders[k].place.norm() < 6.0) {
        EXPECT_TRUE(seen[k]) << "trunk at " << world.cylinders[k].place.transpose();
      }
    }
  }
}

TEST(SweepProjectorTest, GhostsBelowTheGroundDoNotHideIt) {
  Random random(21);
  const TinyWorld world = Orchard();
  for (const double share : {0.01, 0.03, 0.1}) {
    for (const bool mirrored : {true, false}) {
      SweepProjector projector((SweepProjectionOptions()));
      for (int i = 0; i < 3; ++i) {
        const Eigen::Isometry3d pose = LidarAt(0.7, random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0));
        LidarSweep sweep = SeeTinyWorld(world, pose, 0.02, &random);
        for (Eigen::Vector3f& point : sweep.points) {
          if (random.Uniform() > share) continue;
          Eigen::Vector3d p = pose * point.cast<double>();
          p.z() = mirrored ? -p.z() : -3.0 * random.Uniform();
          point = (pose.inverse() * p).cast<float>();
        }
        const PreparedSweep prepared = projector.Prepare(sweep, SweepMotion());
        ASSERT_TRUE(prepared.fit.ok) << share << mirrored << i;
        EXPECT_LT(TiltError(pose, prepared.fit.normal), 1.0) << share << mirrored << i;
        EXPECT_NEAR(prepared.lidar_height, 0.7, 0.12) << share << mirrored << i;
      }
    }
  }
}

TEST(SweepProjectorTest, FindsTheGroundFarBelow) {
  Random random(22);
  TinyWorld world;
  for (int i = 0; i < 20; ++i) {
    world.cylinders.push_back({{random.Uniform(-15.0, 15.0), random.Uniform(-15.0, 15.0)}, 0.1, 2.5});
  }
  for (const double height : {3.0, 4.0}) {
    SweepProjector projector((SweepProjectionOptions()));
    for (int i = 0; i < 2; ++i) {
      const Eigen::Isometry3d pose = LidarAt(height, random.Uniform(-2.0, 2.0), random.Uniform(-2.0, 2.0));
      const PreparedSweep prepared = projector.Prepare(SeeTinyWorld(world, pose, 0.02, &random), SweepMotion());
      ASSERT_TRUE(prepared.fit.ok) << height;
      EXPECT_LT(TiltError(pose, prepared.fit.normal), 0.5) << height;
      EXPECT_NEAR(prepared.fit.height, height, 0.1);
    }
  }
}

TEST(SweepProjectorTest, FindsColumnsAboutTheSpinAxis) {
  Random random(23);
  const Eigen::Isometry3d pose = LidarAt(0.8, 40.0, 0.0);
  LidarSweep sweep = SeeTinyWorld(Orchard(), pose, 0.02, &random);
  for (Eigen::Vector3f& point : sweep.points) point = pose.linear().cast<float>() * point;
  sweep.spin_axis = pose.linear().col(2).cast<float>();
  SweepProjector projector((SweepProjectionOptions()));
  const PreparedSweep prepared = projector.Prepare(sweep, SweepMotion());
  EXPECT_TRUE(prepared.fit.ok);
  EXPECT_NEAR(prepared.column_width, DegToRad(0.4), 1e-4);
  ASSERT_EQ(prepared.phases.size(), sweep.points.size());
  EXPECT_LT(prepared.phases.front(), 0.02f);
  EXPECT_GT(prepared.phases.back(), 0.98f);
}

TEST(SweepProjectorTest, TakesTheCallersAttitude) {
  Random random(2);
  const TinyWorld world = Orchard();
  const Eigen::Isometry3d pose = LidarAt(0.5, 3.0, -2.0);
  SweepProjector projector((SweepProjectionOptions()));
  const PreparedSweep prepared = projector.Prepare(SeeTinyWorld(world, pose, 0.0, &random), SweepMotion());
  const PlanarScan scan = projector.Project(prepared, pose.linear().cast<float>());
  ASSERT_FALSE(scan.points.empty());
  size_t num_near = 0;
  for (const Eigen::Vector2f& point : scan.points) {
    num_near += ToTrunk(world, point.cast<double>()) < 0.02 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(num_near), 0.85 * static_cast<double>(scan.points.size()));
  // Projecting leaves the sweep as it is.
  EXPECT_EQ(projector.Project(prepared, pose.linear().cast<float>()).points, scan.points);
}

TEST(SweepProjectorTest, DeskewsBeforeItProjects) {
  // The lidar turns by 0.2 rad during the sweep.
  Random random(3);
  const TinyWorld world = Orchard();
  LidarSweep moving;
  moving.duration = 0.1;
  for (int piece = 0; piece < 100; ++piece) {
    Eigen::Isometry3d pose = LidarAt(0.5, 0.0, 0.0);
    const double since_middle = ((piece + 0.5) / 100.0 - 0.5) * 0.1;
    pose.linear() = Eigen::AngleAxisd(2.0 * since_middle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const LidarSweep sweep = SeeTinyWorld(world, pose, 0.0, &random, 900);
    for (const Eigen::Vector3f& point : sweep.points) {
      const double turned = (kPi - std::atan2(point.y(), point.x())) / (2.0 * kPi) * 100.0;
      if (turned >= piece && turned < piece + 1) moving.points.push_back(point);
    }
  }
  const auto count_near = [&](const SweepMotion& motion) {
    SweepProjector projector((SweepProjectionOptions()));
    const PreparedSweep prepared = projector.Prepare(moving, motion);
    const PlanarScan scan = projector.Project(prepared, LevelRotation(prepared.ground.normal));
    double num_near = 0.0;
    for (const Eigen::Vector2f& point : scan.points) {
      num_near += ToTrunk(world, point.cast<double>()) < 0.05 ? 1.0 : 0.0;
    }
    return num_near / static_cast<double>(scan.points.size());
  };
  EXPECT_GT(count_near({Eigen::Vector3f::Zero(), {0.0f, 0.0f, 2.0f}}), 0.85);
  EXPECT_LT(count_near(SweepMotion()), 0.7);
}

TEST(SweepProjectorTest, EmptySweepsAreVerdicts) {
  SweepProjector projector((SweepProjectionOptions()));
  for (const size_t size : {0, 1, 2, 3, 100}) {
    LidarSweep sweep;
    sweep.points.assign(size, Eigen::Vector3f(2.0f, 1.0f, 0.1f));
    const PreparedSweep prepared = projector.Prepare(sweep, SweepMotion());
    EXPECT_FALSE(prepared.fit.ok);
    EXPECT_TRUE(prepared.samples.empty());
    EXPECT_EQ(prepared.heights.size(), size);
    const PlanarScan scan = projector.Project(prepared, LevelRotation(prepared.ground.normal));
    EXPECT_LE(scan.points.size(), 1u);
  }
}

TEST(SweepProjectorTest, WithoutGroundTheLastOneCounts) {
  Random random(4);
  const Eigen::Isometry3d pose = LidarAt(0.5, 2.0, 1.0);
  SweepProjector projector((SweepProjectionOptions()));
  const PreparedSweep first = projector.Prepare(SeeTinyWorld(Orchard(), pose, 0.02, &random), SweepMotion());
  ASSERT_TRUE(first.fit.ok);
  const PreparedSweep second = projector.Prepare(LidarSweep(), SweepMotion());
  EXPECT_FALSE(second.fit.ok);
  EXPECT_EQ(second.ground.height, first.fit.height);
  EXPECT_EQ(second.ground.normal, first.fit.normal);
}

TEST(SweepProjectorTest, TakesTheCanopyThatIsGiven) {
  Random random(5);
  SweepProjectionOptions options;
  options.mean_canopy_height = 0.8;
  SweepProjector projector(options);
  const PreparedSweep prepared =
      projector.Prepare(SeeTinyWorld(Orchard(), LidarAt(0.5, 0.0, 0.0), 0.02, &random), SweepMotion());
  EXPECT_EQ(prepared.mean_canopy_height, 0.8f);
}

TEST(SweepProjectorTest, IsTheSameEveryTime) {
  Random random(6);
  std::vector<LidarSweep> sweeps;
  for (int i = 0; i < 3; ++i) {
    sweeps.push_back(SeeTinyWorld(Orchard(), LidarAt(0.5, random.Uniform(-3.0, 3.0), 0.0), 0.02, &random));
  }
  std::vector<PlanarScan> runs[2];
  for (std::vector<PlanarScan>& run : runs) {
    SweepProjector projector((SweepProjectionOptions()));
    PreparedSweep prepared;
    for (const LidarSweep& sweep : sweeps) {
      prepared = projector.Prepare(sweep, SweepMotion(), std::move(prepared));
      run.push_back(projector.Project(prepared, LevelRotation(prepared.ground.normal)));
    }
  }
  for (size_t i = 0; i < sweeps.size(); ++i) {
    EXPECT_EQ(runs[0][i].points, runs[1][i].points);
    EXPECT_EQ(runs[0][i].weights, runs[1][i].weights);
    EXPECT_EQ(runs[0][i].free_ends, runs[1][i].free_ends);
  }
}

}  // namespace
}  // namespace arborslam
