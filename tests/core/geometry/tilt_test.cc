#include "core/geometry/tilt.h"

#include <gtest/gtest.h>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(Tilt, TurnsTheUpDirectionUpright) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d up =
        Eigen::Vector3d(random.Uniform(-0.8, 0.8), random.Uniform(-0.8, 0.8), random.Uniform(0.2, 1.0)).normalized();
    const Tilt3 tilt = TiltFromUp(up);
    EXPECT_TRUE((tilt.Rotation() * up).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
    // The heading of the lidar's x axis stays that of base.
    EXPECT_NEAR(tilt.Rotation()(1, 0), 0.0, 1e-12);
  }
}

TEST(Tilt, LeavesOutTheHeadingOfARotation) {
  const Tilt3 tilt{0.1, -0.2, 0.5};
  const Eigen::Isometry3d T_map_lidar = Lift(SE2(3.0, 4.0, 2.5), tilt);
  const Tilt3 found = TiltOf(T_map_lidar.linear());
  EXPECT_NEAR(found.roll, 0.1, 1e-12);
  EXPECT_NEAR(found.pitch, -0.2, 1e-12);
  EXPECT_TRUE(T_map_lidar.translation().isApprox(Eigen::Vector3d(3.0, 4.0, 0.5)));
}

TEST(Tilt, PositivePitchIsNoseDown) {
  EXPECT_LT((Tilt3{0.0, 0.1, 0.0}.Rotation() * Eigen::Vector3d::UnitX()).z(), 0.0);
  EXPECT_GT((Tilt3{0.1, 0.0, 0.0}.Rotation() * Eigen::Vector3d::UnitY()).z(), 0.0);
}

}  // namespace
}  // namespace arborslam
