#include "frontend/matching/matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/geometry/angles.h"
#include "core/map/free_area.h"
#include "tests/frontend/simulated_run.h"

namespace arborslam {
namespace {

const SearchWindow kNear{0.5, 0.2, 0.01, {}};

Matcher DefaultMatcher() { return Matcher(MatcherOptions(), MhdOptions(), RefinementOptions()); }

PlanarOrchardOptions CleanOptions() {
  PlanarOrchardOptions options;
  options.seed = 2;
  options.spoilt_scans = 0.0;
  return options;
}

TEST(MatcherTest, AcceptsAGoodMatch) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 21, 40));
  const SE2 truth = orchard.TruePose(40);
  const std::vector<Eigen::Vector2f> points = PointsOf(orchard, 40);
  MatchResult match = DefaultMatcher().Match(target, points, truth * SE2(0.35, -0.4, 0.15), kNear);
  DefaultMatcher().CheckUniqueness(target, points, kNear, &match);
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted);
  EXPECT_TRUE(IsUsable(match.verdict));
  EXPECT_LT((match.pose.translation() - truth.translation()).norm(), 0.06);
  EXPECT_LT(std::abs(AngleDifference(match.pose.theta(), truth.theta())), 0.006);
  EXPECT_EQ(match.num_points, static_cast<int>(points.size()));
  EXPECT_EQ(match.num_degenerate, 0);
  EXPECT_GT(match.inlier_ratio, 0.6);
  EXPECT_LT(match.score, 0.1);
  EXPECT_GT(match.num_scored, 0);
}

TEST(MatcherTest, TooFewPointsAreNotMatched) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 10));
  const SE2 prediction(1.0, 2.0, 3.0);
  std::vector<Eigen::Vector2f> points = PointsOf(orchard, 40);
  points.resize(29);
  for (const auto& few : {std::vector<Eigen::Vector2f>(), std::vector<Eigen::Vector2f>{{1.0f, 1.0f}}, points}) {
    for (const MatchResult& match : {DefaultMatcher().Match(target, few, prediction, kNear),
                                     DefaultMatcher().MatchNear(target, few, prediction)}) {
      EXPECT_EQ(match.verdict, MatchVerdict::kTooFewPoints);
      EXPECT_FALSE(IsUsable(match.verdict));
      EXPECT_TRUE(match.pose.IsApprox(prediction));
      EXPECT_TRUE(match.information.isZero());
      EXPECT_EQ(match.num_points, static_cast<int>(few.size()));
    }
  }
}

TEST(MatcherTest, AnEmptyMapHasTooFewPoints) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target({}, 0.05, kTestMaxDistance);
  const MatchResult match = DefaultMatcher().Match(target, PointsOf(orchard, 40), SE2(), kNear);
  EXPECT_EQ(match.verdict, MatchVerdict::kTooFewPoints);
}

TEST(MatcherTest, AForeignWorldIsPoor) {
  PlanarOrchardOptions options = CleanOptions();
  const PlanarOrchard here(options);
  options.seed = 9;
  options.row_spacing = 6.3;
  options.tree_spacing = 3.1;
  const PlanarOrchard elsewhere(options);
  const MatchTarget target = TargetOf(MapOf(elsewhere, 30, 21));
  for (const size_t index : {35u, 40u, 45u}) {
    const MatchResult match = DefaultMatcher().Match(target, PointsOf(here, index), elsewhere.TruePose(index), kNear);
    EXPECT_EQ(match.verdict, MatchVerdict::kPoor) << "score " << match.score;
    EXPECT_FALSE(IsUsable(match.verdict));
  }
}

TEST(MatcherTest, AMapOutOfReachIsPoor) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 10));
  const SE2 far_away(500.0, 500.0, 0.0);
  const MatchResult match = DefaultMatcher().Match(target, PointsOf(orchard, 40), far_away, kNear);
  EXPECT_EQ(match.verdict, MatchVerdict::kPoor);
  EXPECT_TRUE(match.pose.IsApprox(far_away)) << "nothing was found: the prediction stands";
  EXPECT_NEAR(match.score, kTestMaxDistance, 1e-6);
}

// An exact grid of equal trunks, whose ends the lidar does not see.
PlanarOrchardOptions EndlessGrid() {
  PlanarOrchardOptions options = IdealPlanarOrchardOptions();
  options.trees_per_row = 30;
  options.lidar.max_range = 9.0;
  return options;
}

TEST(MatcherTest, AnExactlyRepeatingGridIsAmbiguous) {
  const PlanarOrchard orchard(EndlessGrid());
  const size_t index = 100;  // 28 m into a row of 58 m.
  const MatchTarget target = TargetOf(MapOf(orchard, index - 30, 61, index));
  const std::vector<Eigen::Vector2f> points = PointsOf(orchard, index);
  const SE2 truth = orchard.TruePose(index);
  const SearchWindow beyond_a_tree{2.3, 0.1, 0.01, {}};
  MatchResult match = DefaultMatcher().Match(target, points, truth, beyond_a_tree);
  DefaultMatcher().CheckUniqueness(target, points, beyond_a_tree, &match);
  EXPECT_EQ(match.verdict, MatchVerdict::kAmbiguous);
  EXPECT_FALSE(IsUsable(match.verdict));
  // Whether the question is asked, and whether the window holds the next tree, decides.
  EXPECT_EQ(DefaultMatcher().Match(target, points, truth, beyond_a_tree).verdict, MatchVerdict::kAccepted);
  const SearchWindow before_a_tree{0.8, 0.1, 0.01, {}};
  match = DefaultMatcher().Match(target, points, truth, before_a_tree);
  DefaultMatcher().CheckUniqueness(target, points, before_a_tree, &match);
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted);
}

// Cells of twice the size, as loops take them to tell what is free.
OccupancyGrid FreeGrid() {
  OccupancyGridOptions options;
  options.cell_size *= 2.0;
  options.miss_range *= 2.0;
  return OccupancyGrid(options);
}

TEST(MatcherTest, WhereTheMapOfAGridEndsARivalIsJudgedByWhatWasSeen) {
  const PlanarOrchard orchard(EndlessGrid());
  const size_t index = 100;
  const SE2 truth = orchard.TruePose(index);
  // Nothing is seen farther than 2.6 m ahead and behind, so that the next tree's pose leaves much of the scan without
  // map.
  const auto seen_at = [&](size_t i) {
    PlanarScan scan = ProjectLaserScan(orchard.Scan(i), ProjectionOptions());
    const auto is_far = [&](const Eigen::Vector2f& point) {
      return std::abs((orchard.TruePose(i) * point.cast<double>()).x() - truth.x()) > 2.6;
    };
    scan.points.erase(std::remove_if(scan.points.begin(), scan.points.end(), is_far), scan.points.end());
    scan.free_ends.clear();
    return scan;
  };
  OccupancyGrid grid{OccupancyGridOptions()};
  OccupancyGrid free_grid = FreeGrid();
  for (size_t i = index - 30; i <= index + 30; ++i) {
    if (i == index) continue;
    grid.Insert(orchard.TruePose(i), seen_at(i));
    free_grid.Insert(orchard.TruePose(i), seen_at(i));
  }
  const MatchTarget target = TargetOf(grid);
  const std::vector<Eigen::Vector2f> points = seen_at(index).points;
  const SearchWindow window{2.3, 0.1, 0.01, {}};
  const auto verdict = [&](const std::optional<SeenOnly>& seen_only) {
    MatchResult match = DefaultMatcher().Match(target, points, truth, window);
    DefaultMatcher().CheckUniqueness(target, points, window, &match, seen_only);
    return match.verdict;
  };
  EXPECT_EQ(verdict(std::nullopt), MatchVerdict::kAccepted);
  MinPyramid seen(target.field(), FreeArea(free_grid), 1);
  EXPECT_EQ(verdict(SeenOnly{&seen, 0.4}), MatchVerdict::kAmbiguous);
}

TEST(MatcherTest, AnIrregularOrchardIsNotAmbiguous) {
  PlanarOrchardOptions options = CleanOptions();
  options.position_jitter = 0.6;
  const PlanarOrchard orchard(options);
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 41, 50));
  const std::vector<Eigen::Vector2f> points = PointsOf(orchard, 50);
  const SearchWindow beyond_a_tree{2.3, 0.1, 0.01, {}};
  MatchResult match = DefaultMatcher().Match(target, points, orchard.TruePose(50), beyond_a_tree);
  DefaultMatcher().CheckUniqueness(target, points, beyond_a_tree, &match);
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted);
  OccupancyGrid free_grid = FreeGrid();
  for (size_t i = 30; i < 71; ++i) {
    if (i != 50) free_grid.Insert(orchard.TruePose(i), ProjectLaserScan(orchard.Scan(i), ProjectionOptions()));
  }
  MinPyramid seen(target.field(), FreeArea(free_grid), 1);
  DefaultMatcher().CheckUniqueness(target, points, beyond_a_tree, &match, SeenOnly{&seen, 0.4});
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted) << "by what was seen, too";
}

TEST(MatcherTest, MatchBetterFindsNothingThatIsNotBetter) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 21, 40));
  const std::vector<Eigen::Vector2f> points = PointsOf(orchard, 40);
  const SE2 truth = orchard.TruePose(40);
  const MatchResult match = DefaultMatcher().MatchBetter(target, points, truth, kNear, 1e-3);
  EXPECT_EQ(match.verdict, MatchVerdict::kPoor);
  EXPECT_TRUE(match.pose.IsApprox(truth));
  EXPECT_NEAR(match.score, kTestMaxDistance, 1e-6);
  EXPECT_EQ(DefaultMatcher().MatchBetter(target, points, truth, kNear, 0.15).verdict, MatchVerdict::kAccepted);
}

TEST(MatcherTest, MatchNearRefinesWithoutASearch) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 21, 40));
  const std::vector<Eigen::Vector2f> points = PointsOf(orchard, 40);
  const SE2 truth = orchard.TruePose(40);
  const MatchResult match = DefaultMatcher().MatchNear(target, points, truth * SE2(0.03, 0.02, 0.005));
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted);
  EXPECT_LT((match.pose.translation() - truth.translation()).norm(), 0.06);
  EXPECT_EQ(match.num_scored, 0);
  // A tree's distance away there is nothing to climb.
  const MatchResult lost = DefaultMatcher().MatchNear(target, points, truth * SE2(0.0, 1.2, 0.0));
  EXPECT_GT((lost.pose.translation() - truth.translation()).norm(), 0.5);
}

TEST(MatcherTest, TheSearchUsesAShareOfManyPoints) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 21, 40));
  const std::vector<Eigen::Vector2f> points = PointsOf(orchard, 40);
  ASSERT_GT(points.size(), 200u);
  MatcherOptions options;
  options.max_search_points = 50;
  const SE2 truth = orchard.TruePose(40);
  const MatchResult match =
      Matcher(options, MhdOptions(), RefinementOptions()).Match(target, points, truth * SE2(0.3, 0.3, 0.1), kNear);
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted);
  EXPECT_LT((match.pose.translation() - truth.translation()).norm(), 0.06);
}

TEST(MatcherTest, CostIsScoreAndPenalty) {
  const PlanarOrchard orchard(CleanOptions());
  const MatchTarget target = TargetOf(MapOf(orchard, 30, 21, 40));
  const SE2 prediction = orchard.TruePose(40) * SE2(0.2, 0.1, 0.05);
  const SearchWindow window{0.5, 0.2, 0.01, {0.05, 0.02}};
  const MatchResult match = DefaultMatcher().Match(target, PointsOf(orchard, 40), prediction, window);
  EXPECT_EQ(match.verdict, MatchVerdict::kAccepted);
  EXPECT_NEAR(match.cost, match.score + PenaltyOf(match.pose, prediction, window.penalty), 1e-12);
  EXPECT_GT(match.cost, match.score + 0.008);
}

TEST(MatcherTest, VerdictsHaveNames) {
  std::set<std::string> names;
  for (const MatchVerdict verdict : {MatchVerdict::kAccepted, MatchVerdict::kTooFewPoints, MatchVerdict::kPoor,
                                     MatchVerdict::kAmbiguous, MatchVerdict::kDegenerate}) {
    names.insert(ToString(verdict));
  }
  EXPECT_EQ(names, (std::set<std::string>{"accepted", "too few points", "poor", "ambiguous", "degenerate"}));
  EXPECT_TRUE(IsUsable(MatchVerdict::kDegenerate));
  EXPECT_FALSE(IsUsable(MatchVerdict::kAmbiguous));
}

TEST(MatcherTest, ValidatesItsOptions) {
  EXPECT_EQ(MatcherOptions().Validate(), "");
  MatcherOptions options;
  options.max_score = 0.3;
  EXPECT_NE(options.Validate().find("max_score"), std::string::npos);
  options = {};
  options.min_points = 2;
  EXPECT_NE(options.Validate().find("min_points"), std::string::npos);
  options = {};
  options.max_search_points = 1;
  EXPECT_NE(options.Validate().find("max_search_points"), std::string::npos);
  options = {};
  options.max_distance = 0.0;
  EXPECT_NE(options.Validate().find("max_distance"), std::string::npos);
  options = {};
  options.max_second_ratio = 0.0;
  EXPECT_NE(options.Validate().find("max_second_ratio"), std::string::npos);
}

TEST(MatcherTest, ARefusalNamesItsFirstReason) {
  MatchResult match;
  match.verdict = MatchVerdict::kAccepted;
  match.score = 0.04;
  match.inlier_ratio = 0.8;
  EXPECT_EQ(RefusalReason(match, 0.08, 0.6), "");
  EXPECT_EQ(RefusalReason(match, 0.08, 0.9), "overlap");
  EXPECT_EQ(RefusalReason(match, 0.03, 0.9), "score");
  match.verdict = MatchVerdict::kAmbiguous;
  EXPECT_EQ(RefusalReason(match, 0.03, 0.9), "ambiguous");
}

}  // namespace
}  // namespace arborslam
