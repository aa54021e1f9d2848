#include "backend/localization/localizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/planar_orchard.h"

namespace arborslam {
namespace {

PlanarOrchardOptions OrchardOptions(int seed) {
  PlanarOrchardOptions options;
  options.seed = seed;
  options.rows = 3;
  options.trees_per_row = 9;
  options.spoilt_scans = 0.0;
  return options;
}

// A finished map of an orchard.
struct MappedRun {
  explicit MappedRun(const PlanarOrchard& orchard) : slam(SlamOptions(), 1) {
    for (size_t i = 0; i < orchard.NumScans(); ++i) slam.AddScan(orchard.Scan(i));
    slam.Finish(false);
  }

  Localizer MakeLocalizer(const std::optional<SE2>& initial_pose = std::nullopt) const {
    return Localizer(SlamOptions(), LocalizerOptions(), slam.graph(), slam.keyframes(), slam.submaps(), initial_pose);
  }

  Slam slam;
};

class LocalizerTest : public testing::Test {
 protected:
  LocalizerTest() : orchard_(OrchardOptions(1)), map_(orchard_) {}

  // Where scan `index` was taken, in the map's frame.
  SE2 TruthOf(size_t index) const { return orchard_.TruePose(0).Inverse() * orchard_.TruePose(index); }

  // The scan with a stamp of its own, so that a run may take scans in any order.
  LaserScan ScanAt(size_t index, double stamp) const {
    LaserScan scan = orchard_.Scan(index);
    scan.stamp = stamp;
    return scan;
  }

  void ExpectNear(const LocalizationResult& result, size_t index) const {
    const SE2 truth = TruthOf(index);
    EXPECT_LT((result.T_map_base.translation() - truth.translation()).norm(), 0.3) << index;
    EXPECT_LT(std::abs(AngleDifference(result.T_map_base.theta(), truth.theta())), 0.1) << index;
  }

  const PlanarOrchard orchard_;
  const MappedRun map_;
};

TEST(LocalizerOptions, ValuesOutOfRangeAreNamed) {
  EXPECT_EQ(LocalizerOptions().Validate(), "");
  LocalizerOptions options;
  options.vote_keyframes = 2;
  EXPECT_EQ(options.Validate().substr(0, 14), "vote_keyframes");
  options = {};
  options.min_overlap = NAN;
  EXPECT_EQ(options.Validate().substr(0, 11), "min_overlap");
}

TEST_F(LocalizerTest, FindsItsPlaceWithoutAnyPriorAndKeepsIt) {
  Localizer localizer = map_.MakeLocalizer();
  int num_located = 0;
  const size_t first = 40;
  for (size_t i = first; i < first + 40; ++i) {
    const LocalizationResult result = localizer.AddScan(ScanAt(i, static_cast<double>(i)));
    if (result.state != LocalizationState::kLocated) continue;
    ++num_located;
    ExpectNear(result, i);
  }
  EXPECT_GE(num_located, 31);
}

TEST_F(LocalizerTest, AKidnappedRobotIsLostAndFoundAgain) {
  Localizer localizer = map_.MakeLocalizer();
  double stamp = 0.0;
  for (size_t i = 10; i < 35; ++i) localizer.AddScan(ScanAt(i, stamp++));
  bool was_lost = false;
  bool is_found = false;
  for (size_t i = 90; i < 130 && i < orchard_.NumScans(); ++i) {
    const LocalizationResult result = localizer.AddScan(ScanAt(i, stamp++));
    was_lost |= result.state == LocalizationState::kLost;
    if (was_lost && result.state == LocalizationState::kLocated) {
      is_found = true;
      ExpectNear(result, i);
    }
  }
  EXPECT_TRUE(was_lost);
  EXPECT_TRUE(is_found);
}

TEST_F(LocalizerTest, AnotherOrchardIsNotTakenForTheMap) {
  const PlanarOrchard other(OrchardOptions(77));
  Localizer localizer = map_.MakeLocalizer();
  for (size_t i = 0; i < 60; ++i) {
    const LocalizationResult result = localizer.AddScan(other.Scan(i));
    EXPECT_EQ(result.state, LocalizationState::kNotYetLocated) << i;
    EXPECT_FALSE(result.reason.empty()) << i;
  }
}

TEST_F(LocalizerTest, AnInitialPoseLocatesTheFirstScanAndAWrongOneIsGivenUp) {
  Localizer told = map_.MakeLocalizer(TruthOf(20) * SE2(0.5, -0.4, 0.05));
  const LocalizationResult first = told.AddScan(ScanAt(20, 0.0));
  EXPECT_EQ(first.state, LocalizationState::kLocated);
  EXPECT_TRUE(first.is_fix);
  ExpectNear(first, 20);
  Localizer misled = map_.MakeLocalizer(SE2(500.0, 500.0, 0.0));
  EXPECT_EQ(misled.AddScan(ScanAt(20, 0.0)).state, LocalizationState::kNotYetLocated);
}

}  // namespace
}  // namespace arborslam
