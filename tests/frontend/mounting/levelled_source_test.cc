#include "frontend/mounting/levelled_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/simulation/random.h"
#include "tests/frontend/projection/ring_lidar.h"

namespace arborslam {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Gives what it is told, and throws before scan `fails_at`.
class FakeSource : public ScanSource {
 public:
  explicit FakeSource(std::vector<Scan> scans, size_t fails_at = 1000)
      : scans_(std::move(scans)), fails_at_(fails_at) {}

  std::optional<Scan> Next() override {
    if (next_ == fails_at_) {
      fails_at_ = 1000;
      throw UserError("sweep " + std::to_string(next_), "is damaged", "repair it");
    }
    if (next_ == scans_.size()) return std::nullopt;
    return scans_[next_++];
  }
  std::optional<size_t> NumScans() const override { return scans_.size(); }
  const std::vector<std::string>& Notices() const override { return notices_; }

 private:
  std::vector<Scan> scans_;
  size_t fails_at_;
  size_t next_ = 0;
  std::vector<std::string> notices_ = {"Of the source."};
};

LidarSweep Seen(const Eigen::Isometry3d& pose) {
  Random random(1);
  TinyWorld world;
  world.grass = 0.05;
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector2d place(random.Uniform(-12.0, 12.0), random.Uniform(-12.0, 12.0));
    if (place.norm() > 1.5) world.cylinders.push_back({place, 0.1, 3.0});
  }
  return SeeTinyWorld(world, pose, 0.02, &random, 600);
}

std::vector<LidarSweep> Rest(ScanSource* source) {
  std::vector<LidarSweep> sweeps;
  while (const std::optional<Scan> scan = source->Next()) sweeps.push_back(std::get<LidarSweep>(*scan));
  return sweeps;
}

LevelledSource Level(const LidarSweep& sweep, const SweepFolderOptions& options = {}, int count = 3) {
  return LevelledSource(std::make_unique<FakeSource>(std::vector<Scan>(count, sweep)), options);
}

TEST(LevelledSourceTest, LeavesAUsualMountingAsItIs) {
  const LidarSweep sweep = Seen(LidarAt(0.6, 4.0, -6.0));
  LevelledSource source = Level(sweep, {}, 30);
  EXPECT_THAT(source.Notices(), testing::ElementsAre("Of the source."));
  EXPECT_EQ(source.NumScans(), 30u);
  const std::vector<LidarSweep> given = Rest(&source);
  ASSERT_EQ(given.size(), 30u);
  for (const LidarSweep& same : given) {
    EXPECT_EQ(same.points, sweep.points);
    EXPECT_EQ(same.spin_axis, Eigen::Vector3f::UnitZ());
  }
}

TEST(LevelledSourceTest, TurnsTiltedLidarsUpright) {
  for (const auto& [roll, pitch, word] : {std::tuple(180.0, 0.0, "upside down"), std::tuple(90.0, 0.0, "on its side"),
                                          std::tuple(-40.0, 20.0, "tilted"), std::tuple(0.0, 60.0, "tilted")}) {
    const Eigen::Isometry3d pose = LidarAt(0.8, roll, pitch);
    const LidarSweep sweep = Seen(pose);
    LevelledSource source = Level(sweep);
    EXPECT_THAT(source.Notices(), Contains(HasSubstr(word))) << roll << " " << pitch;
    const std::vector<LidarSweep> given = Rest(&source);
    ASSERT_EQ(given.size(), 3u);
    // Ry Rx keeps the heading of x, so that what is given lies as in the world.
    double worst = 0.0;
    for (size_t i = 0; i < sweep.points.size(); ++i) {
      const Eigen::Vector3d expected = pose.linear() * sweep.points[i].cast<double>();
      worst = std::max(worst, (given[2].points[i].cast<double>() - expected).norm() / expected.norm());
    }
    EXPECT_LT(worst, 0.03) << roll << " " << pitch;
    EXPECT_LT((given[2].spin_axis.cast<double>() - pose.linear().col(2)).norm(), 0.03);
  }
}

TEST(LevelledSourceTest, MovesPointsOfARobotsFrame) {
  const Eigen::Isometry3d pose = LidarAt(0.8, 0.0, 0.0);
  const LidarSweep sweep = Seen(pose);
  for (const float lift : {0.5f, 0.8f, 1.2f}) {
    LidarSweep moved = sweep;
    for (Eigen::Vector3f& point : moved.points) point.z() += lift;
    LevelledSource source = Level(moved);
    EXPECT_THAT(source.Notices(), Contains(HasSubstr("base_link"))) << lift;
    EXPECT_NEAR(Rest(&source)[0].points[0].z(), sweep.points[0].z(), 0.03) << lift;
  }
}

TEST(LevelledSourceTest, SaysWhenThereIsNoGround) {
  LidarSweep wall;
  for (int i = 0; i < 2000; ++i) wall.points.emplace_back(0.01f * static_cast<float>(i) - 10.0f, 3.0f, 0.0f);
  LevelledSource source = Level(wall);
  EXPECT_THAT(source.Notices(), Contains(HasSubstr("input.T_base_lidar states the mounting")));
  EXPECT_EQ(Rest(&source)[0].points, wall.points);
}

TEST(LevelledSourceTest, TakesTheMountingItIsGiven) {
  const Eigen::Isometry3d pose = LidarAt(0.8, 180.0, 0.0);
  const LidarSweep sweep = Seen(pose);
  SweepFolderOptions options;
  options.T_base_lidar = "0.2 0 0.8 180 0 90";
  LevelledSource source = Level(sweep, options);
  EXPECT_THAT(source.Notices(), Not(Contains(HasSubstr("contradict"))));
  const Eigen::Vector3f p = sweep.points[5];
  EXPECT_LT((Rest(&source)[1].points[5] - Eigen::Vector3f(p.y(), p.x(), -p.z())).norm(), 1e-4f);
  options.T_base_lidar = "0 0 0 0 0 0";
  EXPECT_THAT(Level(sweep, options).Notices(), Contains(HasSubstr("contradict")));
  options.T_base_lidar = "0.2,0,0.8,10,0,0";
  options.frame = "base";
  LevelledSource in_base = Level(sweep, options);
  EXPECT_LT((Rest(&in_base)[0].points[5] - (p - Eigen::Vector3f(0.2f, 0.0f, 0.8f))).norm(), 1e-5f);
}

TEST(LevelledSourceTest, StandsDegenerateRecordings) {
  LevelledSource empty(std::make_unique<FakeSource>(std::vector<Scan>()), {});
  EXPECT_FALSE(empty.Next().has_value());
  LevelledSource planar(std::make_unique<FakeSource>(std::vector<Scan>(3, LaserScan())), {});
  int num_scans = 0;
  while (planar.Next()) ++num_scans;
  EXPECT_EQ(num_scans, 3);
  EXPECT_EQ(planar.Notices().size(), 1u);
}

TEST(LevelledSourceTest, ThrowsWhereTheSourceDoes) {
  LevelledSource source(std::make_unique<FakeSource>(std::vector<Scan>(5, Seen(LidarAt(0.6, 0.0, 0.0))), 3), {});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(source.Next().has_value());
  EXPECT_THROW(source.Next(), UserError);
  EXPECT_TRUE(source.Next().has_value()) << "the source goes on";
}

}  // namespace
}  // namespace arborslam
