#include "core/simulation/simulated_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

RunOptions Options(int seed = 1) {
  RunOptions options;
  options.seed = seed;
  options.followers = 2;
  options.carrier.motion = "trot";
  options.carrier.speed = 0.5;
  options.carrier.sensor_height = 0.5;
  options.lidar.columns = 360;
  options.lidar.sweep_duration = 0.05;
  options.lidar.sweep_period = 0.2;
  options.lidar.max_range = 30.0;
  return options;
}

Scene Posts(const RunOptions& options) {
  const ClosedPath path({{0.0, 0.0}, {8.0, 0.0}, {8.0, 4.0}, {-2.0, 4.0}, {-2.0, 0.0}}, 0.8);
  Scene scene{path, {GroundAround(path, options), {}, {}, {}}};
  for (const double x : {-1.0, 2.0, 5.0}) {
    const double ground = scene.world.terrain.Height({x, 2.0});
    scene.world.solids.push_back(Frustum::Between({x, 2.0, ground - 0.2}, {x + 0.1, 2.0, ground + 1.5}, 0.1, 0.05));
  }
  Leaves crown;
  crown.center = {2.0, 2.0, 2.0};
  scene.world.leaves.push_back(crown);
  return scene;
}

TEST(SimulatedRunTest, StampsAreExactAndPosesBelongToTheMiddles) {
  const SimulatedRun run(Options(), Posts(Options()));
  const Trajectory3 truth = run.GroundTruth();
  ASSERT_EQ(truth.poses.size(), run.NumScans());
  EXPECT_EQ(run.NumScans(), 1 + static_cast<size_t>((run.carrier().Duration() - 0.05) / 0.2));
  for (size_t i = 0; i < run.NumScans(); ++i) {
    EXPECT_EQ(run.Start(i), 0.2 * static_cast<double>(i));
    EXPECT_EQ(truth.poses[i].stamp, run.Start(i) + 0.025);
    const Eigen::Isometry3d pose = run.carrier().PoseAt(truth.poses[i].stamp);
    EXPECT_EQ(truth.poses[i].position, pose.translation());
    EXPECT_LT((truth.poses[i].orientation.toRotationMatrix() - pose.linear()).norm(), 1e-12);
    EXPECT_NEAR(truth.poses[i].orientation.norm(), 1.0, 1e-15);
  }
  const LidarSweep sweep = run.Sweep(7);
  EXPECT_EQ(sweep.start, run.Start(7));
  EXPECT_EQ(sweep.duration, 0.05);
  EXPECT_EQ(sweep.Middle(), truth.poses[7].stamp);
}

TEST(SimulatedRunTest, SweepsFollowFromTheSeedAndTheirIndexAlone) {
  const SimulatedRun one(Options(), Posts(Options()));
  const SimulatedRun same(Options(), Posts(Options()));
  const SimulatedRun other(Options(2), Posts(Options(2)));
  EXPECT_EQ(one.Sweep(20).points, same.Sweep(20).points);
  EXPECT_EQ(one.Sweep(3).points, same.Sweep(3).points);
  EXPECT_EQ(one.Sweep(20).points, one.Sweep(20).points);
  EXPECT_NE(one.Sweep(20).points, other.Sweep(20).points);
  // Two sweeps from rest differ by their noise.
  EXPECT_NE(one.Sweep(0).points, one.Sweep(1).points);
  EXPECT_EQ(one.TruePose(20).matrix(), same.TruePose(20).matrix());
  EXPECT_NE(one.TruePose(20).matrix(), other.TruePose(20).matrix());
  EXPECT_EQ(one.Map().occupancy, same.Map().occupancy);
  EXPECT_EQ(one.Control(20).forward, same.Control(20).forward);
  EXPECT_NE(one.Control(20).forward, other.Control(20).forward);
}

TEST(SimulatedRunTest, PointsLieOnTheWorldFromTheTruePosesOfTheirMoments) {
  RunOptions options = Options();
  options.lidar.range_noise = 0.0;
  options.lidar.range_resolution = 0.0;
  options.terrain.grass_height = 0.0;
  const SimulatedRun run(options, Posts(options));
  int elsewhere = 0;
  int on_people = 0;
  int on_posts = 0;
  for (const size_t index : {0u, 60u, 100u, 150u}) {
    const LidarSweep sweep = run.Sweep(index);
    ASSERT_GT(sweep.points.size(), 1000u);
    for (size_t i = 0; i < sweep.points.size(); ++i) {
      const double time = sweep.start + sweep.times[i];
      const Eigen::Vector3d point = run.carrier().PoseAt(time) * sweep.points[i].cast<double>();
      const auto is_on = [&](const Frustum& solid) {
        const double along = (point - solid.base).dot(solid.axis);
        if (along < -0.001 || along > solid.length + 0.001) return false;
        const double across = (point - solid.base - along * solid.axis).norm();
        return std::abs(across - solid.RadiusAt(along)) < 0.002 ||
               (along > solid.length - 0.001 && across < solid.top_radius + 0.001);
      };
      const auto& posts = run.world().solids;
      const auto people = run.world().moving(time);
      if (std::abs(point.z() - run.world().terrain.Height(point.head<2>())) < 0.002) continue;
      if (std::any_of(posts.begin(), posts.end(), is_on)) {
        ++on_posts;
      } else if (std::any_of(people.begin(), people.end(), is_on)) {
        ++on_people;
      } else {
        ASSERT_LE((point - run.world().leaves[0].center).norm(), 1.001) << index << " " << i;
        ++elsewhere;
      }
    }
  }
  EXPECT_GT(on_posts, 50);
  EXPECT_GT(on_people, 50);
  EXPECT_GT(elsewhere, 10);
}

TEST(SimulatedRunTest, PeopleKeepTheirDistanceBehindTheCarrier) {
  const SimulatedRun run(Options(), Posts(Options()));
  for (double time = 0.0; time < run.carrier().Duration(); time += 0.5) {
    const std::vector<Frustum> people = run.world().moving(time);
    ASSERT_EQ(people.size(), 8u);
    for (const Frustum& part : people) {
      const Eigen::Vector2d offset = part.base.head<2>() - run.carrier().PoseAt(time).translation().head<2>();
      ASSERT_GT(offset.norm(), 0.6) << time;
      ASSERT_LT(offset.norm(), 4.0) << time;
    }
  }
  RunOptions alone = Options();
  alone.followers = 0;
  EXPECT_FALSE(SimulatedRun(alone, Posts(alone)).world().moving);
}

TEST(SimulatedRunTest, ControlsAreNoisyButTrueOnAverage) {
  const SimulatedRun run(Options(), Posts(Options()));
  double distance = 0.0;
  double turn = 0.0;
  double error = 0.0;
  for (size_t i = 0; i < run.NumScans(); ++i) {
    const OdometryVelocity control = run.Control(i);
    distance += 0.2 * control.forward;
    turn += 0.2 * control.yaw;
    error += std::abs(control.forward - run.carrier().VelocityAt(run.Middle(i)).forward);
  }
  EXPECT_NEAR(distance, run.PathLength(), 0.1 * run.PathLength());
  EXPECT_NEAR(turn, 2.0 * kPi, 0.6);
  EXPECT_GT(error / static_cast<double>(run.NumScans()), 0.003);
}

TEST(SimulatedRunTest, MapShowsThePostsAroundThePath) {
  RunOptions options = Options();
  options.map_margin = 1.0;
  options.map_resolution = 0.02;
  const SimulatedRun run(options, Posts(options));
  const GridImage map = run.Map();
  EXPECT_NEAR(map.origin_x, -3.0, 0.021);
  EXPECT_NEAR(map.origin_y, -1.0, 0.021);
  EXPECT_NEAR(map.width * map.resolution, 12.0, 0.05);
  EXPECT_NEAR(map.height * map.resolution, 6.0, 0.05);
  const auto cell = [&](double x, double y) {
    const auto column = static_cast<size_t>((x - map.origin_x) / map.resolution);
    const auto row = static_cast<size_t>((y - map.origin_y) / map.resolution);
    return map.occupancy[row * static_cast<size_t>(map.width) + column];
  };
  for (const double x : {-1.0, 2.0, 5.0}) {
    EXPECT_EQ(cell(x, 2.0), 100);
    EXPECT_EQ(cell(x + 0.08, 2.0), 100);
    EXPECT_EQ(cell(x, 2.2), 0);
    EXPECT_EQ(cell(x - 0.3, 2.0), 0);
  }
  EXPECT_EQ(cell(3.0, 0.0), 0);
}

TEST(RunOptionsTest, RefusesWhatCannotBe) {
  EXPECT_EQ(RunOptions().Validate(), "");
  const auto problem = [](auto change) {
    RunOptions options;
    change(&options);
    return options.Validate();
  };
  EXPECT_NE(problem([](RunOptions* o) { o->seed = -1; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->num_scans = 1000001; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->followers = 11; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->map_resolution = 0.0; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->map_margin = -1.0; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->terrain.bumps = -1.0; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->carrier.speed = -1.0; }), "");
  EXPECT_NE(problem([](RunOptions* o) { o->lidar.rings = -1; }), "");
}

}  // namespace
}  // namespace arborslam
