#include "core/simulation/frustum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(FrustumTest, BeamMeetsTheFrontOfAPost) {
  const Frustum post = Frustum::Between({5.0, 0.0, -1.0}, {5.0, 0.0, 2.0}, 0.25, 0.25);
  EXPECT_DOUBLE_EQ(Intersect(post, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}), 4.75);
  EXPECT_DOUBLE_EQ(Intersect(post, {0.0, 0.15, 1.0}, {1.0, 0.0, 0.0}), 4.8);
  EXPECT_DOUBLE_EQ(Intersect(post, {10.0, 0.0, 1.0}, {-1.0, 0.0, 0.0}), 4.75);
  EXPECT_EQ(Intersect(post, {0.0, 0.0, 1.0}, {-1.0, 0.0, 0.0}), kInfinity);
  EXPECT_EQ(Intersect(post, {0.0, 0.0, 2.1}, {1.0, 0.0, 0.0}), kInfinity);
  EXPECT_EQ(Intersect(post, {0.0, 0.26, 1.0}, {1.0, 0.0, 0.0}), kInfinity);
  // Straight down on its upper end.
  EXPECT_DOUBLE_EQ(Intersect(post, {5.1, 0.1, 3.5}, {0.0, 0.0, -1.0}), 1.5);
  EXPECT_EQ(Intersect(post, {5.2, 0.2, 3.5}, {0.0, 0.0, -1.0}), kInfinity);
}

TEST(FrustumTest, BeamMeetsAConeWhereItsRadiusSays) {
  const Frustum cone = Frustum::Between({3.0, 0.0, 0.0}, {3.0, 0.0, 0.5}, 0.2, 0.0);
  EXPECT_NEAR(Intersect(cone, {0.0, 0.0, 0.25}, {1.0, 0.0, 0.0}), 2.9, 1e-12);
  EXPECT_NEAR(Intersect(cone, {0.0, 0.0, 0.45}, {1.0, 0.0, 0.0}), 2.98, 1e-12);
  // Above the tip there is only the mirrored cone of the equation.
  EXPECT_EQ(Intersect(cone, {0.0, 0.0, 0.6}, {1.0, 0.0, 0.0}), kInfinity);
  // Down at 45 deg: z = 1 - x meets 3 - r(z), r = 0.2 (1 - 2 z), at the surface in the plane y = 0.
  const double range = Intersect(cone, {2.0, 0.0, 1.0}, Eigen::Vector3d(1.0, 0.0, -1.0).normalized());
  const double x = 2.0 + range / std::sqrt(2.0);
  const double z = 1.0 - range / std::sqrt(2.0);
  EXPECT_NEAR(3.0 - x, 0.2 * (1.0 - 2.0 * z), 1e-12);
}

bool IsInside(const Frustum& frustum, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = point - frustum.base;
  const double along = offset.dot(frustum.axis);
  return along >= 0.0 && along <= frustum.length && (offset - along * frustum.axis).norm() <= frustum.RadiusAt(along);
}

TEST(FrustumTest, LeaningTaperedTrunksAgreeWithBruteForceSampling) {
  Random random(3);
  int hits = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Vector3d base(random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0), random.Uniform(-0.5, 0.0));
    const Eigen::Vector3d top =
        base + Eigen::Vector3d(random.Uniform(-0.8, 0.8), random.Uniform(-0.8, 0.8), random.Uniform(0.5, 3.0));
    const Frustum trunk = Frustum::Between(base, top, random.Uniform(0.02, 0.4), random.Uniform(0.0, 0.4));
    const Eigen::Vector3d origin(random.Uniform(-3.0, 3.0), random.Uniform(-3.0, 3.0), random.Uniform(0.8, 4.0));
    const Eigen::Vector3d aim =
        base + random.Uniform() * (top - base) +
        0.5 * Eigen::Vector3d(random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0), random.Uniform(-1.0, 1.0));
    const Eigen::Vector3d direction = (aim - origin).normalized();
    // Left out: beams that begin inside or below the lower end, which stands in the ground.
    if (IsInside(trunk, origin) || (origin - base).dot(trunk.axis) < 0.0) continue;
    const double range = Intersect(trunk, origin, direction);
    constexpr double kStep = 0.001;
    double first_inside = kInfinity;
    for (double sample = 0.0; sample < 10.0 && first_inside == kInfinity; sample += kStep) {
      if (IsInside(trunk, origin + sample * direction)) first_inside = sample;
    }
    if (first_inside < kInfinity) {
      ++hits;
      ASSERT_LE(range, first_inside + 1e-9) << trial;
      ASSERT_GE(range, first_inside - kStep - 1e-9) << trial;
    } else if (range < kInfinity) {
      // It grazed the trunk between two samples.
      ASSERT_FALSE(IsInside(trunk, origin + (range + kStep) * direction)) << trial;
      ASSERT_NEAR((trunk.base + (origin + range * direction - trunk.base).dot(trunk.axis) * trunk.axis -
                   (origin + range * direction))
                      .norm(),
                  trunk.RadiusAt((origin + range * direction - trunk.base).dot(trunk.axis)), 0.01)
          << trial;
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(FrustumTest, RadiusRunsEvenlyFromEndToEnd) {
  const Frustum trunk = Frustum::Between({0.0, 0.0, 0.0}, {0.0, 3.0, 4.0}, 0.3, 0.1);
  EXPECT_DOUBLE_EQ(trunk.length, 5.0);
  EXPECT_NEAR((trunk.axis - Eigen::Vector3d(0.0, 0.6, 0.8)).norm(), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(trunk.RadiusAt(0.0), 0.3);
  EXPECT_DOUBLE_EQ(trunk.RadiusAt(2.5), 0.2);
  EXPECT_NEAR(trunk.RadiusAt(5.0), 0.1, 1e-15);
}

}  // namespace
}  // namespace arborslam
