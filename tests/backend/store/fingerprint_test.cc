#include "backend/store/fingerprint.h"

#include <gtest/gtest.h>

namespace arborslam {
namespace {

TEST(Fingerprint, TellsScansApart) {
  LaserScan scan;
  scan.stamp = 1.0;
  scan.ranges = {1.0f, 2.0f, 3.0f};
  const uint64_t print = FingerprintOf(scan);
  EXPECT_NE(print, 0u);
  EXPECT_EQ(FingerprintOf(scan), print);
  LaserScan later = scan;
  later.stamp = 1.1;
  EXPECT_NE(FingerprintOf(later), print);
  // The last one is beyond the eight bytes that are hashed at a time.
  LaserScan other = scan;
  other.ranges[2] = 3.1f;
  EXPECT_NE(FingerprintOf(other), print);
  LaserScan empty;
  EXPECT_NE(FingerprintOf(empty), 0u);
}

TEST(Fingerprint, TellsSweepsApart) {
  LidarSweep sweep;
  sweep.points = {{1.0f, 2.0f, 3.0f}, {4.0f, 5.0f, 6.0f}};
  const uint64_t print = FingerprintOf(sweep);
  sweep.points[1].z() = 6.5f;
  EXPECT_NE(FingerprintOf(sweep), print);
}

}  // namespace
}  // namespace arborslam
