#include "core/map/voxel_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr size_t kPlenty = 1000000;

std::vector<Eigen::Vector3f> RandomSweep(int count, double spread, Random* random) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    const double x = spread * random->Gaussian();
    const double y = spread * random->Gaussian();
    points.push_back(Eigen::Vector3d(x, y, spread * random->Gaussian()).cast<float>());
  }
  return points;
}

// The definition, with an ordered map: what a voxel of this edge holds.
struct Oracle {
  struct Voxel {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0.0;
    std::set<int> sweeps;
  };
  using Key = std::array<int64_t, 3>;

  static Key KeyOf(const Eigen::Vector3d& point, double edge) {
    Key key;
    for (int axis = 0; axis < 3; ++axis) key[static_cast<size_t>(axis)] = std::floor(point(axis) / edge);
    return key;
  }

  void Add(const std::vector<Eigen::Vector3f>& points, int sweep, double edge) {
    for (const Eigen::Vector3f& point : points) {
      Voxel& voxel = voxels[KeyOf(point.cast<double>(), edge)];
      voxel.sum += point.cast<double>();
      voxel.count += 1.0;
      voxel.sweeps.insert(sweep);
    }
  }

  std::map<Key, Voxel> voxels;
};

TEST(VoxelMapTest, KeepsTheMeanOfEveryVoxel) {
  for (const double edge : {0.1, 0.25, 1.0}) {
    Random random(7);
    VoxelMap map(edge, kPlenty);
    Oracle oracle;
    for (int sweep = 0; sweep < 20; ++sweep) {
      const std::vector<Eigen::Vector3f> points = RandomSweep(1000, 0.7, &random);
      map.AddSweep(points);
      oracle.Add(points, sweep, edge);
    }
    EXPECT_EQ(map.size(), oracle.voxels.size());
    EXPECT_EQ(map.voxel_size(), edge);
    for (const int min_sweeps : {1, 2, 5, 21}) {
      std::map<Oracle::Key, Eigen::Vector3d> expected;
      for (const auto& [key, voxel] : oracle.voxels) {
        if (static_cast<int>(voxel.sweeps.size()) >= min_sweeps) expected[key] = voxel.sum / voxel.count;
      }
      const std::vector<Eigen::Vector3f> points = map.Points(min_sweeps);
      ASSERT_EQ(points.size(), expected.size()) << min_sweeps << " sweeps, edge " << edge;
      // A mean may lie on its voxel's face and round across it: look for the nearest of the expected ones.
      for (const Eigen::Vector3f& point : points) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& entry : expected) nearest = std::min(nearest, (entry.second - point.cast<double>()).norm());
        ASSERT_LT(nearest, 1e-5);
      }
    }
  }
}

TEST(VoxelMapTest, PointsComeInTheOrderInWhichTheirVoxelsWereMet) {
  VoxelMap map(1.0, kPlenty);
  map.AddSweep({{5.5f, 0.5f, 0.5f}, {-3.5f, 0.5f, 0.5f}, {5.5f, 0.5f, 0.5f}});
  map.AddSweep({{0.5f, 0.5f, 9.5f}, {-3.25f, 0.5f, 0.5f}});
  EXPECT_THAT(map.Points(1),
              testing::ElementsAre(Eigen::Vector3f(5.5f, 0.5f, 0.5f), Eigen::Vector3f(-3.375f, 0.5f, 0.5f),
                                   Eigen::Vector3f(0.5f, 0.5f, 9.5f)));
  EXPECT_THAT(map.Points(2), testing::ElementsAre(Eigen::Vector3f(-3.375f, 0.5f, 0.5f)));
  EXPECT_TRUE(map.Points(3).empty());
}

TEST(VoxelMapTest, ManyPointsOfOneSweepAreOneSweep) {
  VoxelMap map(0.1, kPlenty);
  map.AddSweep(std::vector<Eigen::Vector3f>(500, Eigen::Vector3f(0.05f, 0.05f, 0.05f)));
  EXPECT_EQ(map.Points(1).size(), 1u);
  EXPECT_TRUE(map.Points(2).empty());
  map.AddSweep({Eigen::Vector3f(0.05f, 0.05f, 0.05f)});
  EXPECT_EQ(map.Points(2).size(), 1u);
}

TEST(VoxelMapTest, NothingAddedIsNothing) {
  VoxelMap map(0.1, kPlenty);
  EXPECT_TRUE(map.Points(0).empty());
  map.AddSweep({});
  EXPECT_TRUE(map.Points(0).empty());
  EXPECT_EQ(map.size(), 0u);
}

TEST(VoxelMapTest, RefusesWhatIsNotFiniteOrTooFarAway) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  VoxelMap map(0.1, kPlenty);
  map.AddSweep({{kNan, 0.0f, 0.0f}, {0.0f, kInf, 0.0f}, {0.0f, 0.0f, -kInf}, {0.0f, 1e30f, 0.0f}, {-2e5f, 0.0f, 0.0f}});
  EXPECT_EQ(map.size(), 0u);
  EXPECT_EQ(map.num_refused(), 5u);
  // The farthest places still have voxels of their own.
  const std::vector<Eigen::Vector3f> corners = {
      {9.9e4f, 9.9e4f, -9.9e4f}, {-9.9e4f, 9.9e4f, 9.9e4f}, {0.0f, 0.0f, 0.0f}};
  map.AddSweep(corners);
  EXPECT_EQ(map.num_refused(), 5u);
  EXPECT_EQ(map.Points(1), corners);
}

TEST(VoxelMapTest, MergesWhenItIsFull) {
  Random random(3);
  VoxelMap map(0.1, 200);
  Oracle oracle;
  std::vector<std::vector<Eigen::Vector3f>> sweeps;
  for (int sweep = 0; sweep < 10; ++sweep) {
    sweeps.push_back(RandomSweep(1000, 0.7, &random));
    map.AddSweep(sweeps.back());
    ASSERT_LE(map.size(), 200u);
  }
  ASSERT_GT(map.voxel_size(), 0.15);
  for (int sweep = 0; sweep < 10; ++sweep) oracle.Add(sweeps[static_cast<size_t>(sweep)], sweep, map.voxel_size());
  // Of the means nothing is lost: they are those of a map that had had these voxels from the start.
  const std::vector<Eigen::Vector3f> points = map.Points(1);
  ASSERT_EQ(points.size(), oracle.voxels.size());
  for (const Eigen::Vector3f& point : points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [key, voxel] : oracle.voxels) {
      nearest = std::min(nearest, (voxel.sum / voxel.count - point.cast<double>()).norm());
    }
    ASSERT_LT(nearest, 1e-5);
  }
  EXPECT_LE(map.Points(10).size(), points.size());
  EXPECT_GT(map.Points(5).size(), 0u);
}

TEST(VoxelMapTest, FarPointsMergeUntilThereIsRoom) {
  VoxelMap map(0.01, 9);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 40; ++i)
    points.emplace_back(100.0f * static_cast<float>(i), -50.0f * static_cast<float>(i), 0.0f);
  map.AddSweep(points);
  EXPECT_LE(map.size(), 9u);
  EXPECT_EQ(map.num_refused(), 0u);
  EXPECT_GE(map.voxel_size(), 400.0);
}

TEST(VoxelMapTest, MeansOfVeryManyPointsKeepTheirDigits) {
  VoxelMap map(0.1, kPlenty);
  Random random(5);
  double sum = 0.0;
  int count = 0;
  for (int sweep = 0; sweep < 300; ++sweep) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 1000; ++i) {
      points.emplace_back(static_cast<float>(random.Uniform(0.02, 0.09)), 0.05f, 0.05f);
      sum += static_cast<double>(points.back().x());
      ++count;
    }
    map.AddSweep(points);
  }
  ASSERT_EQ(map.size(), 1u);
  EXPECT_NEAR(map.Points(1)[0].x(), sum / count, 1e-5);
}

}  // namespace
}  // namespace arborslam
