#include "backend/terrain/scan_tilts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kLidarHeight = 0.6;  // [m]

// Two runs along one line over bumpy ground; the second one has its own idea of height and level.
struct TwoRuns {
  PoseGraph graph;
  std::vector<PosedScan> scans;
  size_t num_first = 0;

  static double Ground(const Eigen::Vector2d& place) {
    return 0.05 * place.x() + 0.2 * std::sin(0.4 * place.x()) - 0.1 * place.y();
  }

  // @param lift, slope the second run's ground is higher by `lift` + `slope` * place [m].
  TwoRuns(double lift, const Eigen::Vector2d& slope) {
    Random random(3);
    for (int run = 0; run < 2; ++run) {
      for (int i = 0; i < 30; ++i) {
        const SE2 pose(0.8 * i, run == 0 ? 0.0 : 0.7 * std::sin(0.3 * i), run == 0 ? 0.1 : 2.5);
        const KeyframeId id{static_cast<int>(scans.size())};
        graph.AddNode(id, pose);
        PosedScan scan;
        scan.keyframe = id;
        const auto seen = [&](const Eigen::Vector2d& place) {
          return Ground(place) + (run == 0 ? 0.0 : lift + slope.dot(place));
        };
        scan.tilt.z = seen(pose.translation()) + kLidarHeight;
        std::vector<GroundSample> ground;
        for (int k = 0; k < 60; ++k) {
          const Eigen::Vector2d place(random.Uniform(-4.0, 4.0), random.Uniform(-4.0, 4.0));
          GroundSample sample;
          sample.position << place.cast<float>(), static_cast<float>(seen(pose * place) - scan.tilt.z);
          sample.weight = 1.0f;
          ground.push_back(sample);
        }
        scan.ground = std::move(ground);
        scans.push_back(scan);
      }
      if (run == 0) num_first = scans.size();
    }
  }

  // The greatest error in the height of the ground that the second run saw.
  double GreatestError() const {
    double greatest = 0.0;
    for (size_t i = num_first; i < scans.size(); ++i) {
      const Eigen::Isometry3d T_map_lidar = Lift(graph.Pose(scans[i].keyframe), scans[i].tilt);
      const auto ground = scans[i].ground.Get();
      for (const GroundSample& sample : *ground) {
        const Eigen::Vector3d point = T_map_lidar * sample.position.cast<double>();
        greatest = std::max(greatest, std::abs(point.z() - Ground(point.head<2>())));
      }
    }
    return greatest;
  }
};

TEST(LayOnKnownGroundTest, TakesAwayLiftAndLean) {
  TwoRuns runs(3.0, {0.03, -0.02});
  EXPECT_GT(runs.GreatestError(), 2.0);
  const std::vector<PosedScan> before = runs.scans;
  LayOnKnownGround(TerrainOptions(), runs.graph, runs.num_first, &runs.scans);
  EXPECT_LT(runs.GreatestError(), 0.1);
  for (size_t i = 0; i < runs.num_first; ++i) EXPECT_EQ(runs.scans[i].tilt.z, before[i].tilt.z);
}

TEST(LayOnKnownGroundTest, LeavesWhatLiesRightAndWhatIsElsewhere) {
  TwoRuns runs(0.0, {0.0, 0.0});
  LayOnKnownGround(TerrainOptions(), runs.graph, runs.num_first, &runs.scans);
  EXPECT_LT(runs.GreatestError(), 0.05);

  TwoRuns apart(3.0, {0.0, 0.0});
  for (size_t i = apart.num_first; i < apart.scans.size(); ++i) {
    apart.graph.SetPose(apart.scans[i].keyframe, SE2(500.0 + static_cast<double>(i), 0.0, 0.0));
  }
  const double z = apart.scans.back().tilt.z;
  LayOnKnownGround(TerrainOptions(), apart.graph, apart.num_first, &apart.scans);
  EXPECT_EQ(apart.scans.back().tilt.z, z);
}

TEST(ScanTiltsTest, PlanarScansStayAsTheyAre) {
  PoseGraph graph;
  std::vector<PosedScan> scans(4);
  for (size_t i = 0; i < scans.size(); ++i) {
    scans[i].keyframe = KeyframeId{static_cast<int>(i)};
    graph.AddNode(scans[i].keyframe, SE2(static_cast<double>(i), 0.0, 0.0));
  }
  LayOnKnownGround(TerrainOptions(), graph, 2, &scans);
  SmoothTilts(TerrainOptions(), graph, &scans);
  for (const PosedScan& scan : scans) {
    EXPECT_EQ(scan.tilt.z, 0.0);
    EXPECT_EQ(scan.tilt.roll, 0.0);
  }
}

TEST(SmoothTiltsTest, RunsThatWereLaidOnOneGroundStayOnIt) {
  TwoRuns runs(1.0, {0.0, 0.0});
  LayOnKnownGround(TerrainOptions(), runs.graph, runs.num_first, &runs.scans);
  SmoothTilts(TerrainOptions(), runs.graph, &runs.scans);
  // Where both came by, they are as high over the map as the lidar is over the ground.
  for (size_t i = 0; i < runs.num_first; ++i) {
    const double first = runs.scans[i].tilt.z;
    const double second = runs.scans[runs.num_first + i].tilt.z;
    const Eigen::Vector2d place = runs.graph.Pose(runs.scans[i].keyframe).translation();
    const Eigen::Vector2d other = runs.graph.Pose(runs.scans[runs.num_first + i].keyframe).translation();
    EXPECT_NEAR(second - first, TwoRuns::Ground(other) - TwoRuns::Ground(place), 0.12) << i;
  }
}

}  // namespace
}  // namespace arborslam
