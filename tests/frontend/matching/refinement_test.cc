#include "frontend/matching/refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/angles.h"
#include "tests/frontend/simulated_run.h"

namespace arborslam {
namespace {

constexpr double kCell = 0.05;

RefinementResult RefineDefault(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                               const SE2& initial, const SE2& prediction) {
  return Refine(target, points, initial, prediction, MhdOptions(), RefinementOptions());
}

// Thin posts on a crooked grid, 0.8 m apart at least.
std::vector<OccupiedCell> Posts(std::mt19937* random) {
  std::uniform_real_distribution<float> off(-0.1f, 0.1f);
  std::vector<OccupiedCell> cells;
  for (int x = -5; x <= 5; ++x) {
    for (int y = -5; y <= 5; ++y) {
      cells.push_back(
          {Eigen::Vector2f(static_cast<float>(x) + off(*random), static_cast<float>(y) + off(*random)), 1.0f});
    }
  }
  return cells;
}

std::vector<Eigen::Vector2f> Seen(const std::vector<OccupiedCell>& cells, const SE2& T_target_base) {
  const SE2 T_base_target = T_target_base.Inverse();
  std::vector<Eigen::Vector2f> points;
  for (const OccupiedCell& cell : cells) {
    points.push_back((T_base_target * cell.centroid.cast<double>()).cast<float>());
  }
  return points;
}

// A wall along x at y = 2.
std::vector<OccupiedCell> Wall() {
  std::vector<OccupiedCell> cells;
  for (double x = -6.0; x <= 6.0; x += kCell) {
    cells.push_back({Eigen::Vector2d(x, 2.012).cast<float>(), 1.0f});
  }
  return cells;
}

TEST(RefinementTest, FindsAKnownPoseWithinAMillimetre) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> shift(-0.06, 0.06);
  std::uniform_real_distribution<double> turn(-0.01, 0.01);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  for (int trial = 0; trial < 50; ++trial) {
    const std::vector<OccupiedCell> cells = Posts(&random);
    const MatchTarget target(cells, kCell, kTestMaxDistance);
    const SE2 truth(10.0 * shift(random), 10.0 * shift(random), angle(random));
    const SE2 initial = truth * SE2(shift(random), shift(random), turn(random));
    const RefinementResult result = RefineDefault(target, Seen(cells, truth), initial, initial);
    EXPECT_TRUE(result.pose.IsApprox(truth, 1e-3)) << result.pose << " instead of " << truth;
    EXPECT_LT(result.mhd.score, 1e-3);
    EXPECT_EQ(result.num_degenerate, 0);
  }
}

TEST(RefinementTest, OutliersDoNotPull) {
  std::mt19937 random(22);
  const std::vector<OccupiedCell> cells = Posts(&random);
  const MatchTarget target(cells, kCell, kTestMaxDistance);
  const SE2 truth(0.3, 0.2, 0.4);
  std::vector<Eigen::Vector2f> points = Seen(cells, truth);
  // A fifth of the points stands 15 cm to one side.
  for (size_t i = 0; i < points.size(); i += 5) points[i].x() += 0.15f;
  const RefinementResult result = RefineDefault(target, points, truth * SE2(0.03, 0.02, 0.0), truth);
  EXPECT_TRUE(result.pose.IsApprox(truth, 2e-3)) << result.pose;
}

TEST(RefinementTest, FindsAKnownPoseInAnExactOrchard) {
  const PlanarOrchard orchard(IdealPlanarOrchardOptions());
  // Trunks are seen from all sides, but never again from exactly here: cells make the rest of the error.
  for (const size_t index : {20u, 40u, 60u}) {
    const MatchTarget target = TargetOf(MapOf(orchard, index - 10, 21, index));
    const SE2 truth = orchard.TruePose(index);
    const SE2 initial = truth * SE2(0.05, -0.04, 0.01);
    const RefinementResult result = RefineDefault(target, PointsOf(orchard, index), initial, initial);
    EXPECT_TRUE(result.pose.IsApprox(truth, 0.006)) << (truth.Inverse() * result.pose);
  }
}

TEST(RefinementTest, AlongAWallThePredictionIsKept) {
  const MatchTarget target(Wall(), kCell, kTestMaxDistance);
  for (const double theta : {0.0, 0.7, -2.5}) {
    SCOPED_TRACE(theta);
    const SE2 truth(0.0, 0.0, theta);
    // The middle of the wall is seen.
    std::vector<Eigen::Vector2f> points;
    for (double x = -3.0; x <= 3.0; x += 0.03) {
      points.push_back((truth.Inverse() * Eigen::Vector2d(x, 2.012)).cast<float>());
    }
    const SE2 prediction(0.11, 0.08, theta + 0.01);
    const SE2 initial(-0.04, 0.03, theta - 0.01);
    const RefinementResult result = RefineDefault(target, points, initial, prediction);
    ASSERT_EQ(result.num_degenerate, 1);
    const Eigen::Vector3d direction = result.degenerate_basis.col(0);
    EXPECT_NEAR(std::abs(direction.x() * std::cos(theta) - direction.y() * std::sin(theta)), 1.0, 1e-2)
        << "the unknown direction is the wall's, in the base frame: " << direction.transpose();
    EXPECT_NEAR(result.pose.x(), prediction.x(), 0.01);
    EXPECT_NEAR(result.pose.y(), 0.0, 2e-3);
    EXPECT_NEAR(AngleDifference(result.pose.theta(), theta), 0.0, 2e-3);
    Eigen::Vector3d unknown = direction;
    unknown.z() /= RefinementOptions().lever_arm;
    EXPECT_NEAR((result.information * unknown).norm(), 0.0, 1e-6 * result.information.norm());
  }
}

TEST(RefinementTest, WithoutPointsNothingIsKnown) {
  const MatchTarget target(Wall(), kCell, kTestMaxDistance);
  const SE2 prediction(0.3, 0.2, 0.1);
  const RefinementResult result = RefineDefault(target, {}, SE2(0.1, 0.1, 0.0), prediction);
  EXPECT_EQ(result.num_degenerate, 3);
  EXPECT_TRUE(result.pose.IsApprox(prediction, 1e-6)) << result.pose;
  EXPECT_TRUE(result.information.isZero());
  EXPECT_NEAR(result.mhd.score, kTestMaxDistance, 1e-6);
}

TEST(RefinementTest, PointsThatMeetNothingSayNothing) {
  const MatchTarget target(Wall(), kCell, kTestMaxDistance);
  const SE2 prediction(0.3, 0.2, 0.1);
  const std::vector<Eigen::Vector2f> points(50, Eigen::Vector2f(40.0f, 40.0f));
  const RefinementResult result = RefineDefault(target, points, SE2(), prediction);
  EXPECT_EQ(result.num_degenerate, 3);
  EXPECT_TRUE(result.pose.IsApprox(prediction, 1e-6)) << result.pose;
  EXPECT_TRUE(result.information.isZero());
  EXPECT_EQ(result.mhd.inlier_ratio, 0.0);
}

TEST(RefinementTest, AnEmptyMapSaysNothing) {
  const MatchTarget target({}, kCell, kTestMaxDistance);
  const RefinementResult result = RefineDefault(target, {Eigen::Vector2f(1.0f, 1.0f)}, SE2(), SE2(0.1, 0.0, 0.0));
  EXPECT_EQ(result.num_degenerate, 3);
  EXPECT_TRUE(result.information.isZero());
}

TEST(RefinementTest, OneAndTwoPointsAreNotTrusted) {
  // What the association alone says: half of D_max.
  constexpr double kLeastTrust = 1.001 / (0.25 * kTestMaxDistance * kTestMaxDistance);
  std::mt19937 random(23);
  const std::vector<OccupiedCell> cells = Posts(&random);
  const MatchTarget target(cells, kCell, kTestMaxDistance);
  const std::vector<Eigen::Vector2f> all = Seen(cells, SE2());
  const RefinementResult one = RefineDefault(target, {all[3]}, SE2(0.02, 0.0, 0.0), SE2());
  EXPECT_EQ(one.num_degenerate, 1) << "a point leaves the turn about it open";
  EXPECT_LE(one.information(0, 0), kLeastTrust);
  const RefinementResult two = RefineDefault(target, {all[3], all[90]}, SE2(0.02, 0.0, 0.0), SE2());
  EXPECT_TRUE(two.pose.IsApprox(SE2(), 1e-3)) << two.pose;
  EXPECT_LE(two.information(0, 0), kLeastTrust) << "two points leave nothing to tell an error by";
}

TEST(RefinementTest, InformationIsSymmetricAndFinite) {
  std::mt19937 random(24);
  std::uniform_real_distribution<float> place(-8.0f, 8.0f);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<OccupiedCell> cells;
    std::vector<Eigen::Vector2f> points;
    for (int i = 0; i < 1 + 4 * trial; ++i) {
      cells.push_back({Eigen::Vector2f(place(random), place(random)), 1.0f});
      points.emplace_back(place(random), trial % 3 == 0 ? 1.0f : place(random));
    }
    const MatchTarget target(cells, kCell, kTestMaxDistance);
    const RefinementResult result = RefineDefault(target, points, SE2(), SE2());
    ASSERT_TRUE(result.information.allFinite());
    EXPECT_TRUE(result.information.isApprox(result.information.transpose(), 1e-9));
    EXPECT_TRUE(result.pose.vector().allFinite());
    for (int i = 0; i < 3; ++i) EXPECT_GE(result.information(i, i), 0.0);
  }
}

TEST(RefinementTest, ValidatesItsOptions) {
  EXPECT_EQ(RefinementOptions().Validate(), "");
  const auto rejects = [](auto change, const char* key) {
    RefinementOptions options;
    change(&options);
    return options.Validate().find(key) != std::string::npos;
  };
  EXPECT_TRUE(rejects([](RefinementOptions* o) { o->max_iterations = 0; }, "max_iterations"));
  EXPECT_TRUE(rejects([](RefinementOptions* o) { o->robust_scale = 0.0; }, "robust_scale"));
  EXPECT_TRUE(rejects([](RefinementOptions* o) { o->min_step = -1.0; }, "min_step"));
  EXPECT_TRUE(rejects([](RefinementOptions* o) { o->min_information_ratio = 1.0; }, "min_information_ratio"));
  EXPECT_TRUE(
      rejects([](RefinementOptions* o) { o->lever_arm = std::numeric_limits<double>::quiet_NaN(); }, "lever_arm"));
  EXPECT_TRUE(rejects([](RefinementOptions* o) { o->covariance_step = 0.0; }, "covariance_step"));
}

}  // namespace
}  // namespace arborslam
