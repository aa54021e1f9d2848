#include "core/simulation/planar_orchard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/config/config_schema.h"
#include "core/geometry/angles.h"

namespace arborslam {
namespace {

// FNV-1a over the ranges in whole millimetres.
uint64_t HashOfScans(const PlanarOrchard& orchard, size_t num_scans) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (size_t i = 0; i < num_scans; ++i) {
    for (const float range : orchard.Scan(i).ranges) {
      const auto millimetres = static_cast<uint32_t>(std::isfinite(range) ? std::lround(range * 1000.0) : -1);
      for (int byte = 0; byte < 4; ++byte) {
        hash = (hash ^ ((millimetres >> (8 * byte)) & 0xff)) * 0x100000001b3ULL;
      }
    }
  }
  return hash;
}

TEST(PlanarOrchardTest, IsTheSameOnEveryMachine) {
  const PlanarOrchard orchard{PlanarOrchardOptions()};
  EXPECT_EQ(HashOfScans(orchard, 100), 14798036834542903353ULL);
}

TEST(PlanarOrchardTest, SeedsDiffer) {
  PlanarOrchardOptions options;
  const uint64_t first = HashOfScans(PlanarOrchard(options), 2);
  options.seed = 2;
  EXPECT_NE(HashOfScans(PlanarOrchard(options), 2), first);
}

TEST(PlanarOrchardTest, ScansDoNotDependOnTheOrderTheyAreDrawnIn) {
  const PlanarOrchard orchard{PlanarOrchardOptions()};
  const LaserScan late = orchard.Scan(50);
  const LaserScan early = orchard.Scan(3);
  const PlanarOrchard other{PlanarOrchardOptions()};
  EXPECT_EQ(other.Scan(3).ranges, early.ranges);
  EXPECT_EQ(other.Scan(50).ranges, late.ranges);
  EXPECT_NE(early.ranges, late.ranges);
  PlanarOrchardOptions shorter;
  shorter.num_scans = 60;
  EXPECT_EQ(PlanarOrchard(shorter).NumScans(), 60u);
  EXPECT_EQ(PlanarOrchard(shorter).Scan(50).ranges, late.ranges) << "the length of a run must not change its scans";
}

TEST(PlanarOrchardTest, GroundTruthIsTheTruePoseOfEveryScan) {
  const PlanarOrchard orchard{PlanarOrchardOptions()};
  const Trajectory truth = orchard.GroundTruth();
  ASSERT_EQ(truth.size(), orchard.NumScans());
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(truth[i].stamp, orchard.Scan(i).stamp);
    EXPECT_TRUE(truth[i].pose.IsApprox(orchard.TruePose(i), 0.0));
    if (i > 0) {
      EXPECT_GT(truth[i].stamp, truth[i - 1].stamp);
    }
  }
}

TEST(PlanarOrchardTest, PathIsThatOfTheRecordings) {
  const PlanarOrchard orchard{PlanarOrchardOptions()};
  EXPECT_GT(orchard.PathLength(), 120.0);
  EXPECT_LT(orchard.PathLength(), 180.0);
  double sum = 0.0;
  double largest_turn = 0.0;
  for (size_t i = 1; i < orchard.NumScans(); ++i) {
    const SE2 motion = orchard.TruePose(i - 1).Inverse() * orchard.TruePose(i);
    EXPECT_LT(motion.translation().norm(), 0.55) << i;
    sum += motion.translation().norm();
    largest_turn = std::max(largest_turn, std::abs(motion.theta()));
  }
  EXPECT_NEAR(sum / static_cast<double>(orchard.NumScans() - 1), 0.28, 0.02);
  EXPECT_GT(largest_turn, 0.5) << "the turns at the headland are sharp";
}

TEST(PlanarOrchardTest, PathReturnsToItsStart) {
  for (const int rows : {2, 3, 4, 5, 6}) {
    PlanarOrchardOptions options = IdealPlanarOrchardOptions();
    options.rows = rows;
    const PlanarOrchard orchard(options);
    const size_t last = orchard.NumScans() - 1;
    EXPECT_TRUE(orchard.TruePose(0).IsApprox(SE2())) << rows;
    EXPECT_TRUE(orchard.TruePose(last).IsApprox(SE2(), 1e-9)) << rows;
    // Beyond the end it goes around again.
    EXPECT_TRUE(orchard.TruePose(last + 7).IsApprox(orchard.TruePose(7), 1e-9)) << rows;
    EXPECT_EQ(orchard.TruePose(3).y(), 0.0);
  }
  const PlanarOrchard jittered{PlanarOrchardOptions()};
  const SE2 closure = jittered.TruePose(0).Inverse() * jittered.TruePose(jittered.NumScans() - 1);
  EXPECT_LT(closure.translation().norm(), 0.3);
}

TEST(PlanarOrchardTest, JitterHasItsSpread) {
  PlanarOrchardOptions options;
  options.num_scans = 5000;
  PlanarOrchardOptions ideal = options;
  ideal.step_jitter = 0.0;
  ideal.sway = 0.0;
  ideal.heading_jitter = 0.0;
  const PlanarOrchard orchard(options);
  const PlanarOrchard steady(ideal);
  double across = 0.0;
  double heading = 0.0;
  for (size_t i = 0; i < 5000; ++i) {
    const SE2 off = steady.TruePose(i).Inverse() * orchard.TruePose(i);
    across += off.y() * off.y();
    heading += off.theta() * off.theta();
  }
  EXPECT_NEAR(std::sqrt(across / 5000.0), 0.03, 0.003);
  // The position along the path changes the heading in the turns as well.
  EXPECT_NEAR(std::sqrt(heading / 5000.0), 0.06, 0.006);
}

TEST(PlanarOrchardTest, IdealOrchardIsAnExactGrid) {
  const PlanarOrchardOptions options = IdealPlanarOrchardOptions();
  const PlanarOrchard orchard(options);
  ASSERT_EQ(orchard.trunks().size(), 5u * 13u);
  ASSERT_EQ(orchard.world().discs.size(), 5u * 13u);
  EXPECT_TRUE(orchard.world().foliage.empty());
  EXPECT_TRUE(orchard.world().walls.empty());
  for (size_t i = 0; i < orchard.trunks().size(); ++i) {
    const Disc& trunk = orchard.trunks()[i];
    EXPECT_DOUBLE_EQ(trunk.center.x(), 2.0 * static_cast<double>(i % 13));
    EXPECT_DOUBLE_EQ(trunk.center.y(), 4.5 * (static_cast<double>(i / 13) - 0.5));
    EXPECT_DOUBLE_EQ(trunk.radius, 0.09);
  }
}

TEST(PlanarOrchardTest, EveryReturnOfAnIdealScanLiesOnATrunk) {
  const PlanarOrchard orchard(IdealPlanarOrchardOptions());
  for (size_t index = 0; index < orchard.NumScans(); index += 20) {
    const LaserScan scan = orchard.Scan(index);
    const SE2 pose = orchard.TruePose(index);
    int returns = 0;
    for (size_t beam = 0; beam < scan.ranges.size(); ++beam) {
      if (!std::isfinite(scan.ranges[beam])) continue;
      ++returns;
      const double range = scan.ranges[beam];
      const Eigen::Vector2d point =
          pose * Eigen::Vector2d(range * std::cos(scan.Bearing(beam)), range * std::sin(scan.Bearing(beam)));
      double nearest = 1e9;
      for (const Disc& trunk : orchard.trunks()) {
        nearest = std::min(nearest, std::abs((point - trunk.center).norm() - trunk.radius));
      }
      ASSERT_LT(nearest, 1e-5) << index << " " << beam;
    }
    EXPECT_GT(returns, 50) << index;
  }
}

TEST(PlanarOrchardTest, TrunksStayWithinTheirSpreadAndSomeAreMissing) {
  PlanarOrchardOptions options;
  options.rows = 40;
  options.trees_per_row = 50;
  const PlanarOrchard orchard(options);
  const double kept = static_cast<double>(orchard.trunks().size()) / 2000.0;
  EXPECT_NEAR(kept, 0.92, 4.0 * std::sqrt(0.08 * 0.92 / 2000.0));
  for (const Disc& trunk : orchard.trunks()) {
    EXPECT_LE(std::abs(trunk.radius - 0.09), 0.03);
    EXPECT_LE(std::abs(trunk.center.x() - 2.0 * std::round(trunk.center.x() / 2.0)), 0.15);
  }
  EXPECT_EQ(orchard.world().foliage.size(), 2 * orchard.trunks().size());
}

TEST(PlanarOrchardTest, FoliageChangesFromScanToScanAndTrunksDoNot) {
  PlanarOrchardOptions options;
  options.step_jitter = options.sway = options.heading_jitter = options.spoilt_scans = 0.0;
  options.lidar.range_noise = options.lidar.drop_out = 0.0;
  const PlanarOrchard orchard(options);
  const size_t once_around = orchard.NumScans() - 1;
  // The same place, once around later.
  ASSERT_TRUE(orchard.TruePose(5).IsApprox(orchard.TruePose(5 + once_around), 1e-9));
  const LaserScan first = orchard.Scan(5);
  const LaserScan second = orchard.Scan(5 + once_around);
  int same = 0;
  int different = 0;
  for (size_t beam = 0; beam < first.ranges.size(); ++beam) {
    if (!std::isfinite(first.ranges[beam])) continue;
    (std::abs(first.ranges[beam] - second.ranges[beam]) < 0.005 ? same : different)++;
  }
  EXPECT_GT(same, 50);
  EXPECT_GT(different, 50);
}

TEST(PlanarOrchardTest, SpoiltScansAreAsFrequentAsAskedFor) {
  PlanarOrchardOptions options;
  options.spoilt_scans = 0.1;
  const PlanarOrchard orchard(options);
  int spoilt = 0;
  for (size_t i = 0; i < 10000; ++i) spoilt += orchard.IsSpoilt(i) ? 1 : 0;
  EXPECT_NEAR(spoilt / 10000.0, 0.1, 4.0 * std::sqrt(0.09 / 10000.0));

  // A scan that is not spoilt is the same with and without spoilt ones in the run.
  PlanarOrchardOptions level = options;
  level.spoilt_scans = 0.0;
  const PlanarOrchard level_orchard(level);
  int different = 0;
  for (size_t i = 0; i < 200; ++i) {
    if (orchard.IsSpoilt(i)) {
      different += orchard.Scan(i).ranges != level_orchard.Scan(i).ranges ? 1 : 0;
    } else {
      EXPECT_EQ(orchard.Scan(i).ranges, level_orchard.Scan(i).ranges);
    }
  }
  EXPECT_GT(different, 5);
}

TEST(PlanarOrchardTest, NothingStandsInTheWay) {
  for (const int rows : {2, 3, 4, 5}) {
    PlanarOrchardOptions options;
    options.rows = rows;
    const PlanarOrchard orchard(options);
    for (size_t i = 0; i < orchard.NumScans(); ++i) {
      for (const Disc& disc : orchard.world().discs) {
        ASSERT_GT((orchard.TruePose(i).translation() - disc.center).norm(), disc.radius + 0.5) << rows << " " << i;
      }
    }
  }
}

TEST(PlanarOrchardOptionsTest, ValidateNamesTheKey) {
  EXPECT_EQ(PlanarOrchardOptions().Validate(), "");
  EXPECT_EQ(IdealPlanarOrchardOptions().Validate(), "");
  const auto problem = [](auto change) {
    PlanarOrchardOptions options;
    change(&options);
    return options.Validate();
  };
  EXPECT_EQ(problem([](auto* o) { o->rows = 1; }), "rows is 1, must lie in [2, 200]");
  EXPECT_EQ(problem([](auto* o) { o->missing_trees = 1.5; }), "missing_trees is 1.5, must lie in [0, 1]");
  EXPECT_EQ(problem([](auto* o) { o->radius_spread = 0.09; }), "radius_spread is 0.09, must lie in [0, trunk_radius)");
  EXPECT_EQ(problem([](auto* o) { o->lidar.beams = 1; }), "beams is 1, must lie in [3, 100000]");
  EXPECT_EQ(problem([](auto* o) { o->step = 0.0; }), "step is 0.0, must lie in [0.001, 10]");
  EXPECT_EQ(problem([](auto* o) { o->row_spacing = 0.2; }),
            "row_spacing is 0.2, must leave room between trunks for the robot");
  EXPECT_NE(problem([](auto* o) { o->seed = -1; }), "");
  EXPECT_NE(problem([](auto* o) { o->sway = std::nan(""); }), "");
  EXPECT_NE(problem([](auto* o) { o->fence_post_spacing = 1e-9; }), "");
}

TEST(PlanarOrchardOptionsTest, EveryKeyIsBoundOnce) {
  PlanarOrchardOptions options;
  ConfigSchema schema;
  schema.AddSection("planar_orchard", &options);
  schema.ApplyOverride("planar_orchard.max_range=12.5");
  EXPECT_EQ(options.lidar.max_range, 12.5);
  schema.ApplyOverride("planar_orchard.hedge=false");
  EXPECT_FALSE(options.hedge);
}

}  // namespace
}  // namespace arborslam
