#include "frontend/matching/match_target.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kCell = 0.05;
constexpr double kMaxDistance = 0.2;

Eigen::Matrix2f Shape(const MatchTarget::Landmark& landmark) {
  Eigen::Matrix2f shape;
  shape << landmark.information.x(), landmark.information.y(), landmark.information.y(), landmark.information.z();
  return shape;
}

// A wall through the origin in the direction `angle`.
std::vector<OccupiedCell> Wall(double angle) {
  std::vector<OccupiedCell> cells;
  for (double along = -3.0; along <= 3.0; along += kCell) {
    cells.push_back({Eigen::Vector2d(along * std::cos(angle), along * std::sin(angle)).cast<float>(), 1.0f});
  }
  return cells;
}

TEST(MatchTargetTest, AWallTellsNothingOfThePlaceAlongIt) {
  for (const double angle : {0.0, 0.5, 0.25 * kPi, 0.5 * kPi, 2.2}) {
    SCOPED_TRACE(angle);
    const MatchTarget target(Wall(angle), kCell, kMaxDistance);
    const Eigen::Vector2f along(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    const Eigen::Vector2f across(-along.y(), along.x());
    for (const MatchTarget::Landmark& landmark : target.landmarks()) {
      if (landmark.centroid.norm() > 2.5f) continue;  // The ends look shorter.
      EXPECT_LT(along.dot(Shape(landmark) * along), 0.1f);
      EXPECT_NEAR(across.dot(Shape(landmark) * across), 1.0f, 0.01f);
      EXPECT_NEAR(along.dot(Shape(landmark) * across), 0.0f, 0.02f);
    }
  }
}

TEST(MatchTargetTest, ARoundClumpTellsTheSameInAllDirections) {
  std::vector<OccupiedCell> cells;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      cells.push_back({Eigen::Vector2f(0.05f * static_cast<float>(x), 0.05f * static_cast<float>(y)), 1.0f});
    }
  }
  const MatchTarget target(cells, kCell, kMaxDistance);
  for (const MatchTarget::Landmark& landmark : target.landmarks()) {
    const Eigen::Matrix2f shape = Shape(landmark);
    EXPECT_NEAR(shape(0, 0), 1.0f, 0.1f);
    EXPECT_NEAR(shape(1, 1), 1.0f, 0.1f);
    EXPECT_NEAR(shape(0, 1), 0.0f, 0.1f);
  }
}

TEST(MatchTargetTest, ASingleLandmarkTellsAll) {
  const MatchTarget target({{Eigen::Vector2f(-7.31f, 4.02f), 2.0f}}, kCell, kMaxDistance);
  ASSERT_EQ(target.landmarks().size(), 1u);
  EXPECT_TRUE(Shape(target.landmarks()[0]).isIdentity(1e-3f));
  EXPECT_EQ(target.landmarks()[0].weight, 1.0f);
}

TEST(MatchTargetTest, ShapesNeverGainNorTurnNegative) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  std::uniform_real_distribution<float> log_odds(0.2f, 3.5f);
  std::vector<OccupiedCell> cells;
  for (int i = 0; i < 300; ++i)
    cells.push_back({Eigen::Vector2f(50.0f + place(random), place(random)), log_odds(random)});
  const MatchTarget target(cells, kCell, kMaxDistance);
  for (const MatchTarget::Landmark& landmark : target.landmarks()) {
    const Eigen::Matrix2f shape = Shape(landmark);
    EXPECT_GE(shape.determinant(), -1e-5f);
    EXPECT_GE(shape.trace(), 1.0f - 1e-4f);
    EXPECT_LE(shape.trace(), 2.0f + 1e-4f);
  }
}

TEST(MatchTargetTest, WeightsAreSharesOfTheFirmestEvidence) {
  const MatchTarget target({{Eigen::Vector2f(0.0f, 0.0f), 1.0f}, {Eigen::Vector2f(3.0f, 0.0f), 4.0f}}, kCell,
                           kMaxDistance);
  EXPECT_FLOAT_EQ(target.landmarks()[0].weight, 0.25f);
  EXPECT_FLOAT_EQ(target.landmarks()[1].weight, 1.0f);
}

TEST(MatchTargetTest, FindsTheNearestLandmarkWithinDMax) {
  const MatchTarget target({{Eigen::Vector2f(0.02f, 0.02f), 1.0f}, {Eigen::Vector2f(1.02f, 0.02f), 1.0f}}, kCell,
                           kMaxDistance);
  ASSERT_NE(target.Nearest(Eigen::Vector2f(0.9f, 0.0f)), nullptr);
  EXPECT_FLOAT_EQ(target.Nearest(Eigen::Vector2f(0.9f, 0.0f))->centroid.x(), 1.02f);
  EXPECT_FLOAT_EQ(target.Nearest(Eigen::Vector2f(0.1f, 0.1f))->centroid.x(), 0.02f);
  EXPECT_EQ(target.Nearest(Eigen::Vector2f(0.5f, 0.0f)), nullptr);
  EXPECT_EQ(target.Nearest(Eigen::Vector2f(100.0f, -100.0f)), nullptr);
}

TEST(MatchTargetTest, AnEmptyMapIsEmpty) {
  const MatchTarget target({}, kCell, kMaxDistance);
  EXPECT_TRUE(target.empty());
  EXPECT_EQ(target.Nearest(Eigen::Vector2f(0.0f, 0.0f)), nullptr);
  EXPECT_FLOAT_EQ(target.field().Distance(Eigen::Vector2f(0.0f, 0.0f)), target.field().max_distance());
}

TEST(MatchTargetTest, ThePyramidGrowsWhenMoreLevelsAreAskedFor) {
  const MatchTarget target(Wall(0.3), kCell, kMaxDistance);
  EXPECT_GE(target.Pyramid(2).num_levels(), 2);
  EXPECT_GE(target.Pyramid(5).num_levels(), 5);
  EXPECT_GE(target.Pyramid(3).num_levels(), 5) << "levels that are there are kept";
}

}  // namespace
}  // namespace arborslam
