#include "core/io/point_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace arborslam {
namespace {

struct Driver {
  std::string name;
  std::vector<double> raw_times;
  double sweep_duration;  // [s], as far as is known beforehand.
  double unit;
  bool is_absolute;
};

TEST(FindPointTimeFormat, TellsTheWaysOfTheDriversApart) {
  const Driver drivers[] = {
      {"Velodyne", {0.0, 0.0998}, 0.1, 1.0, false},
      {"Velodyne, stamped at the end", {-0.0998, 0.0}, 0.1, 1.0, false},
      {"from the middle", {0.05, -0.05}, 0.1, 1.0, false},
      {"milliseconds", {0.0, 99.0}, 0.1, 1e-3, false},
      {"microseconds", {12.0, 99900.0}, 0.1, 1e-6, false},
      {"Ouster", {0.0, 99980000.0}, 0.1, 1e-9, false},
      {"Ouster at 20 Hz", {0.0, 49990000.0}, 0.1, 1e-9, false},
      {"Hesai", {1664464000.02, 1664464000.12}, 0.1, 1.0, true},
      {"RoboSense, since it was switched on", {31.02, 31.12}, 0.1, 1.0, true},
      {"microseconds since 1970", {1664464000.02e6, 1664464000.12e6}, 0.1, 1e-6, true},
      {"nanoseconds since 1970", {1664464000.02e9, 1664464000.12e9}, 0.1, 1e-9, true},
      {"a sector of an eighth", {0.050, 0.0625}, 0.1, 1.0, false},
      {"a sweep of 2 s", {0.0, 1.9e9}, 2.0, 1e-9, false},
      {"a packet of 1.3 ms", {0.0, 1.3e-3}, 1.4e-3, 1.0, false},
  };
  for (const Driver& driver : drivers) {
    const std::optional<PointTimeFormat> format = FindPointTimeFormat(driver.raw_times, driver.sweep_duration);
    ASSERT_TRUE(format) << driver.name;
    EXPECT_EQ(format->unit, driver.unit) << driver.name;
    EXPECT_EQ(format->is_absolute, driver.is_absolute) << driver.name;
  }
}

TEST(FindPointTimeFormat, IsNoneWhenTheTimesSpanNoSweep) {
  EXPECT_FALSE(FindPointTimeFormat({}, 0.1));
  EXPECT_FALSE(FindPointTimeFormat({1.0}, 0.1));
  EXPECT_FALSE(FindPointTimeFormat({1664464000.0, 1664464000.0, 1664464000.0}, 0.1)) << "Stamps as float32.";
  EXPECT_FALSE(FindPointTimeFormat({0.0, 1e-6}, 0.1));
  EXPECT_FALSE(FindPointTimeFormat({0.0, 1e12}, 0.1));
  EXPECT_FALSE(FindPointTimeFormat({-std::numeric_limits<double>::max(), std::numeric_limits<double>::max()}, 0.1));
}

TEST(PointTimeFormat, NamesItsUnit) {
  EXPECT_EQ((PointTimeFormat{1.0, false}.UnitName()), "seconds");
  EXPECT_EQ((PointTimeFormat{1e-3, false}.UnitName()), "milliseconds");
  EXPECT_EQ((PointTimeFormat{1e-6, false}.UnitName()), "microseconds");
  EXPECT_EQ((PointTimeFormat{1e-9, false}.UnitName()), "nanoseconds");
}

TEST(SpanOfPointTimes, IsInSecondsInAnyOrder) {
  const std::optional<PointTimeSpan> span = SpanOfPointTimes({5e7, -1e7, 8e7, 0.0}, {1e-9, false}, 0.1);
  ASSERT_TRUE(span);
  EXPECT_DOUBLE_EQ(span->first, -0.01);
  EXPECT_DOUBLE_EQ(span->last, 0.08);
  EXPECT_TRUE(SpanOfPointTimes({3.0}, {1.0, false}, 0.1)) << "A sweep of one point has a time.";
  EXPECT_FALSE(SpanOfPointTimes({}, {1.0, false}, 0.1));
  EXPECT_TRUE(SpanOfPointTimes({0.0, 0.25}, {1.0, false}, 0.25));
  EXPECT_FALSE(SpanOfPointTimes({0.0, 0.26}, {1.0, false}, 0.25));
}

}  // namespace
}  // namespace arborslam
