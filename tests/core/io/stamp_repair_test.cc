#include "core/io/stamp_repair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

// `count` stamps about `step` [s] apart from `start` [s] on, with a pause of 30 s in the middle.
std::vector<double> Clock(size_t count, double start, double step, uint64_t seed) {
  Random random(seed);
  std::vector<double> stamps;
  for (size_t i = 0; i < count; ++i) {
    const double pause = i < count / 2 ? 0.0 : 30.0;
    stamps.push_back(start + pause + step * (static_cast<double>(i) + random.Uniform(-0.1, 0.1)));
  }
  return stamps;
}

void ExpectRising(const std::vector<double>& stamps) {
  for (size_t i = 1; i < stamps.size(); ++i) ASSERT_GT(stamps[i], stamps[i - 1]) << i;
}

TEST(StampRepair, LeavesRightStampsAsTheyAre) {
  for (const double start : {0.0, 12.5, 604700.0, 1.7e9}) {
    for (const double step : {0.02, 0.1, 4.5}) {
      const std::vector<double> stamps = Clock(60, start, step, 1);
      const RepairedStamps repaired = RepairStamps(stamps, 0.1);
      EXPECT_EQ(repaired.seconds, stamps);
      EXPECT_TRUE(repaired.notices.empty());
    }
  }
}

TEST(StampRepair, FindsTheUnit) {
  for (const double unit : {1e3, 1e6, 1e9}) {
    for (const double start : {0.0, 1.7e9}) {
      std::vector<double> raw;
      for (int i = 0; i < 50; ++i) raw.push_back(std::round(unit * (start + 0.1 * i)));
      const RepairedStamps repaired = RepairStamps(raw, 0.1);
      if (unit == 1e3 && start == 0.0) continue;  // 100 s apart or 100 ms: not decidable below a minute's step.
      ASSERT_EQ(repaired.notices.size(), 1u) << unit << " " << start;
      for (int i = 0; i < 50; ++i) EXPECT_NEAR(repaired.seconds[static_cast<size_t>(i)], start + 0.1 * i, 1e-3);
    }
  }
}

TEST(StampRepair, KeepsTheStepsBehindAClockThatWasSetBack) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const std::vector<double> right = Clock(80, 1.7e9, 0.25, seed);
    const auto from = static_cast<size_t>(random.Uniform(20.0, 60.0));
    const double back = random.Uniform(100.0, 604800.0);
    std::vector<double> stamps = right;
    for (size_t i = from; i < stamps.size(); ++i) stamps[i] -= back;
    const RepairedStamps repaired = RepairStamps(stamps, 0.1);
    ASSERT_EQ(repaired.notices.size(), 1u);
    ExpectRising(repaired.seconds);
    for (size_t i = 1; i < stamps.size(); ++i) {
      if (i == from) continue;
      EXPECT_NEAR(repaired.seconds[i] - repaired.seconds[i - 1], right[i] - right[i - 1], 1e-6);
    }
    EXPECT_NEAR(repaired.seconds[from] - repaired.seconds[from - 1], 0.25, 0.06);
  }
}

TEST(StampRepair, ReplacesSingleReadingsOnly) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const std::vector<double> right = Clock(100, 1.7e9, 0.1, seed);
    std::vector<double> stamps = right;
    std::vector<bool> is_wrong(100, false);
    for (int k = 0; k < 5; ++k) {
      const auto i = static_cast<size_t>(random.Uniform(1.0, 99.0));
      is_wrong[i] = true;
      stamps[i] = k == 0                           ? std::numeric_limits<double>::quiet_NaN()
                  : random.Uniform(0.0, 1.0) < 0.5 ? right[i] - 1e4
                                                   : right[i] + 1e4;
    }
    const RepairedStamps repaired = RepairStamps(stamps, 0.1);
    ExpectRising(repaired.seconds);
    EXPECT_FALSE(repaired.notices.empty());
    for (size_t i = 0; i < stamps.size(); ++i) {
      if (is_wrong[i]) continue;
      EXPECT_EQ(repaired.seconds[i], right[i]) << seed << " " << i;
    }
  }
}

TEST(StampRepair, SpreadsACoarseClock) {
  std::vector<double> stamps;
  for (int i = 0; i < 100; ++i) stamps.push_back(1.7e9 + 128.0 * std::floor(4.5 * i / 128.0));
  const RepairedStamps repaired = RepairStamps(stamps, 1.0);
  ExpectRising(repaired.seconds);
  EXPECT_NEAR(repaired.seconds.back() - repaired.seconds.front(), 4.5 * 99, 128.0);
}

TEST(StampRepair, CountsWhereStampsSayNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> nothing = {{0.0, 0.0, 0.0},           {nan, nan, nan},
                                                    {0.0, 1e-160, 2e-160},     {infinity, -infinity, nan},
                                                    {5.3e-315, 5.4e-315, 0.0}, {1e300, 2e300, 3e300}};
  for (const std::vector<double>& stamps : nothing) {
    const RepairedStamps repaired = RepairStamps(stamps, 0.5);
    ASSERT_EQ(repaired.seconds.size(), 3u);
    EXPECT_DOUBLE_EQ(repaired.seconds[1] - repaired.seconds[0], 0.5);
    EXPECT_DOUBLE_EQ(repaired.seconds[2] - repaired.seconds[1], 0.5);
    EXPECT_EQ(repaired.notices.size(), 1u);
  }
  EXPECT_TRUE(RepairStamps({}, 0.1).seconds.empty());
  EXPECT_EQ(RepairStamps({nan}, 0.1).seconds, std::vector<double>{0.0});
  EXPECT_EQ(RepairStamps({7.0}, 0.1).seconds, std::vector<double>{7.0});
}

}  // namespace
}  // namespace arborslam
