#include "frontend/projection/upright_lines.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "core/geometry/tilt.h"

namespace arborslam {
namespace {

// Posts at 4 m all around that lean away from the lidar by `slope`, one column each, seen by a lidar tilted by `tilt`.
PreparedSweep Posts(double slope, const Tilt3& tilt) {
  PreparedSweep sweep;
  sweep.column_width = static_cast<float>(DegToRad(0.4));
  sweep.mean_canopy_height = 2.0f;
  const Eigen::Matrix3d to_lidar = tilt.Rotation().transpose();
  for (double bearing = -3.0; bearing < 3.1; bearing += 0.3) {
    for (double height = 0.3; height < 1.7; height += 0.2) {
      const double z = height - 0.5;
      const double range = 4.0 + slope * z;
      const Eigen::Vector3d point(range * std::cos(bearing), range * std::sin(bearing), z);
      sweep.points.push_back((to_lidar * point).cast<float>());
      sweep.heights.push_back(static_cast<float>(height));
    }
  }
  return sweep;
}

TEST(FindUprightLines, MeasuresHowThingsLean) {
  const Tilt3 tilt{0.05, -0.08, 0.5};
  for (const double slope : {-0.1, 0.0, 0.05}) {
    const std::vector<UprightLine> lines = FindUprightLines(Posts(slope, tilt), tilt.Rotation().cast<float>());
    ASSERT_EQ(lines.size(), 21u);
    for (const UprightLine& line : lines) {
      EXPECT_NEAR(line.slope, slope, 1e-3);
      EXPECT_NEAR(line.direction.norm(), 1.0f, 1e-5f);
      EXPECT_NEAR(line.range, 4.0f, 0.1f);
      EXPECT_GT(line.spread, 1.0f);
    }
  }
}

TEST(FindUprightLines, ShowsAnAttitudeThatIsWrong) {
  // The base is taken to be pitched by 0.05 rad less than the lidar is: what stands ahead seems to lean to the robot.
  const std::vector<UprightLine> lines =
      FindUprightLines(Posts(0.0, {0.0, 0.05, 0.5}), Tilt3{0.0, 0.0, 0.5}.Rotation().cast<float>());
  ASSERT_GT(lines.size(), 15u);
  for (const UprightLine& line : lines) EXPECT_NEAR(line.slope, -0.05f * line.direction.x(), 0.01f);
}

TEST(FindUprightLines, LeavesOutWhatIsNoLine) {
  PreparedSweep sweep;
  sweep.column_width = 0.007f;
  sweep.mean_canopy_height = 2.0f;
  const auto add = [&sweep](float range, float height) {
    sweep.points.emplace_back(range, 0.0f, height - 0.5f);
    sweep.heights.push_back(height);
  };
  EXPECT_TRUE(FindUprightLines(sweep, Eigen::Matrix3f::Identity()).empty());
  // Two returns, three too close over one another, and a branch above the canopy.
  add(3.0f, 0.4f);
  add(3.0f, 1.2f);
  add(5.0f, 0.4f);
  add(5.0f, 0.5f);
  add(5.0f, 0.6f);
  for (float height = 2.1f; height < 3.0f; height += 0.1f) add(7.0f, height);
  EXPECT_TRUE(FindUprightLines(sweep, Eigen::Matrix3f::Identity()).empty());
}

}  // namespace
}  // namespace arborslam
