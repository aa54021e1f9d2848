#include "core/simulation/person.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

TEST(PersonTest, StandsUprightOnTheGroundWhereToldTo) {
  const auto person = PersonAt(SE2(3.0, -2.0, kPi / 2.0), 0.4, 1.8, 0.0);
  double low = 1e9;
  double high = -1e9;
  for (const Frustum& part : person) {
    const Eigen::Vector3d top = part.base + part.length * part.axis;
    low = std::min(low, part.base.z());
    high = std::max(high, top.z());
    EXPECT_LT((part.base.head<2>() - Eigen::Vector2d(3.0, -2.0)).norm(), 0.11);
  }
  EXPECT_NEAR(low, 0.4, 1e-12);
  EXPECT_NEAR(high, 2.2, 1e-12);
  // Facing +y, the left leg is towards -x.
  EXPECT_NEAR(person[0].base.x(), 2.9, 1e-12);
}

TEST(PersonTest, LegsSwingAgainstEachOther) {
  const auto person = PersonAt(SE2(), 0.0, 1.8, 1.0);
  EXPECT_NEAR(person[0].base.x(), 0.3, 1e-12);
  EXPECT_NEAR(person[1].base.x(), -0.3, 1e-12);
  // The hips stay.
  const Eigen::Vector3d hip = person[0].base + person[0].length * person[0].axis;
  EXPECT_NEAR(hip.x(), 0.0, 1e-12);
}

}  // namespace
}  // namespace arborslam
