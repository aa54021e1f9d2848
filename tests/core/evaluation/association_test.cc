#include "core/evaluation/association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/error.h"

namespace arborslam {
namespace {

// Poses at the given stamps, x = 10 * stamp within a kilometre.
Trajectory3 AtStamps(const std::vector<double>& stamps) {
  Trajectory3 trajectory;
  for (const double stamp : stamps) {
    trajectory.poses.push_back({stamp, {std::fmod(10.0 * stamp, 1000.0), 0.0, 0.0}, Eigen::Quaterniond::Identity()});
  }
  return trajectory;
}

AssociationOptions Tolerance(double max_time_difference, double max_interpolation_gap = 0.0) {
  AssociationOptions options;
  options.max_time_difference = max_time_difference;
  options.max_interpolation_gap = max_interpolation_gap;
  return options;
}

std::string ErrorOf(const Trajectory3& estimate, const Trajectory3& reference) {
  try {
    Associate(estimate, reference, {}, "a.tum against b.tum");
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(AssociationTest, PairsTheNearestWithinTheToleranceAndCountsTheRest) {
  const AssociationResult result =
      Associate(AtStamps({0.0, 1.01, 2.0, 7.0}), AtStamps({0.015, 1.0, 2.5, 3.0, 4.0}), Tolerance(0.02), "test");
  ASSERT_EQ(result.pairs.size(), 2u);
  EXPECT_EQ(result.pairs[0].estimate.stamp, 0.0);
  EXPECT_EQ(result.pairs[0].reference.stamp, 0.015);
  EXPECT_EQ(result.pairs[1].estimate.stamp, 1.01);
  EXPECT_EQ(result.pairs[1].reference.stamp, 1.0);
  EXPECT_EQ(result.unmatched_estimate, 2u);
  EXPECT_EQ(result.unmatched_reference, 3u);
  EXPECT_TRUE(result.has_headings);
}

TEST(AssociationTest, AReferencePoseServesOnlyTheNearestEstimate) {
  const AssociationResult result = Associate(AtStamps({0.7, 0.9, 1.05, 1.2}), AtStamps({1.0}), Tolerance(0.5), "test");
  ASSERT_EQ(result.pairs.size(), 1u);
  EXPECT_EQ(result.pairs[0].estimate.stamp, 1.05);
  EXPECT_EQ(result.unmatched_estimate, 3u);
  EXPECT_EQ(result.unmatched_reference, 0u);
}

TEST(AssociationTest, OfTwoAsNearTheEarlierWins) {
  const AssociationResult result = Associate(AtStamps({0.75, 1.25}), AtStamps({1.0}), Tolerance(0.5), "test");
  ASSERT_EQ(result.pairs.size(), 1u);
  EXPECT_EQ(result.pairs[0].estimate.stamp, 0.75);
}

TEST(AssociationTest, OrderOfTheInputDoesNotMatter) {
  const AssociationResult result =
      Associate(AtStamps({2.0, 0.0, 1.0}), AtStamps({1.0, 2.0, 0.0}), Tolerance(0.02), "test");
  ASSERT_EQ(result.pairs.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(result.pairs[i].estimate.stamp, static_cast<double>(i));
    EXPECT_EQ(result.pairs[i].reference.stamp, static_cast<double>(i));
  }
}

TEST(AssociationTest, MatchesBruteForceOnRandomStamps) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    std::uniform_real_distribution<double> stamp(0.0, 10.0);
    std::vector<double> estimates(1 + random() % 30);
    std::vector<double> references(1 + random() % 30);
    for (double& value : estimates) value = stamp(random);
    for (double& value : references) value = stamp(random);
    std::sort(estimates.begin(), estimates.end());
    std::sort(references.begin(), references.end());
    const double tolerance = 20.0;  // Everything is near enough, so the rule of the nearest alone decides.
    // An estimate is paired if it is the nearest of all estimates whose nearest reference is its own.
    std::vector<std::pair<double, double>> expected;
    const auto nearest = [&](double value) {
      return *std::min_element(references.begin(), references.end(),
                               [&](double a, double b) { return std::abs(a - value) < std::abs(b - value); });
    };
    for (const double estimate : estimates) {
      const double reference = nearest(estimate);
      const bool is_best = std::none_of(estimates.begin(), estimates.end(), [&](double other) {
        return nearest(other) == reference && std::abs(other - reference) < std::abs(estimate - reference);
      });
      if (is_best) expected.emplace_back(estimate, reference);
    }
    const AssociationResult result = Associate(AtStamps(estimates), AtStamps(references), Tolerance(tolerance), "test");
    ASSERT_EQ(result.pairs.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(result.pairs[i].estimate.stamp, expected[i].first);
      EXPECT_EQ(result.pairs[i].reference.stamp, expected[i].second);
    }
    EXPECT_EQ(result.unmatched_estimate, estimates.size() - expected.size());
    EXPECT_EQ(result.unmatched_reference, references.size() - expected.size());
  }
}

TEST(AssociationTest, InterpolatesPositionAndRotationAcrossShortGapsOnly) {
  Trajectory3 reference = AtStamps({0.0, 1.0, 3.0});
  reference.poses[1].orientation = Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ());
  const AssociationResult result =
      Associate(AtStamps({-0.01, 0.25, 1.0, 2.0, 3.01, 5.0}), reference, Tolerance(0.02, 1.5), "test");
  ASSERT_EQ(result.pairs.size(), 4u);
  EXPECT_EQ(result.pairs[0].reference.stamp, 0.0);  // Before the start: the nearest, no extrapolation.
  EXPECT_EQ(result.pairs[1].reference.stamp, 0.25);
  EXPECT_NEAR(result.pairs[1].reference.position.x(), 2.5, 1e-12);
  EXPECT_NEAR(result.pairs[1].reference.orientation.angularDistance(reference.poses[0].orientation), 0.25, 1e-12);
  EXPECT_EQ(result.pairs[2].reference.stamp, 1.0);
  EXPECT_EQ(result.pairs[3].reference.stamp, 3.0);
  EXPECT_EQ(result.unmatched_estimate, 2u);
  EXPECT_EQ(result.unmatched_reference, 0u);
}

TEST(AssociationTest, HeadingsNeedBothTrajectories) {
  const Trajectory3 with = AtStamps({0.0});
  Trajectory3 without = with;
  without.has_orientation = false;
  EXPECT_FALSE(Associate(with, without, {}, "test").has_headings);
  EXPECT_FALSE(Associate(without, with, {}, "test").has_headings);
}

TEST(AssociationTest, NothingInCommonIsAnErrorThatGivesBothTimeRanges) {
  const std::string error = ErrorOf(AtStamps({1.5, 2.5}), AtStamps({1680000100.25, 1680000200.5}));
  EXPECT_EQ(error,
            "a.tum against b.tum: no stamps match within 0.02 s: the estimate runs from 1.5 s to 2.5 s, the reference "
            "from 1680000100.25 s to 1680000200.5 s; check that both use the same clock, or allow a larger time "
            "difference");
}

TEST(AssociationTest, RefusesWhatCannotBeMeasured) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Trajectory3 good = AtStamps({0.0, 1.0});
  EXPECT_NE(ErrorOf({}, good).find("the estimate has no poses"), std::string::npos);
  EXPECT_NE(ErrorOf(good, {}).find("the reference has no poses"), std::string::npos);
  Trajectory3 bad = good;
  bad.poses[1].stamp = nan;
  EXPECT_NE(ErrorOf(bad, good).find("pose 2 of the estimate has a stamp that is not finite"), std::string::npos);
  for (const double value : {nan, inf, -1e12}) {
    bad = good;
    bad.poses[0].position.y() = value;
    EXPECT_NE(ErrorOf(good, bad).find("pose 1 of the reference has a coordinate"), std::string::npos) << value;
  }
  for (const double value : {nan, inf, 0.0}) {
    bad = good;
    bad.poses[0].orientation = Eigen::Quaterniond(value, 0.0, 0.0, 0.0);
    EXPECT_NE(ErrorOf(good, bad).find("an orientation that is no rotation"), std::string::npos) << value;
  }
  EXPECT_THROW(Associate(good, good, Tolerance(-1.0), "test"), std::invalid_argument);
  EXPECT_THROW(Associate(good, good, Tolerance(nan), "test"), std::invalid_argument);
  EXPECT_THROW(Associate(good, good, Tolerance(0.02, inf), "test"), std::invalid_argument);
  EXPECT_EQ(Tolerance(0.0, 0.0).Validate(), "");
}

TEST(AssociationTest, NormalisesOrientationsThatWereRoundedWhenWritten) {
  Trajectory3 rounded = AtStamps({0.0});
  rounded.poses[0].orientation = Eigen::Quaterniond(0.7, 0.0, 0.0, 0.7);
  EXPECT_NEAR(Associate(rounded, rounded, {}, "test").pairs[0].estimate.orientation.norm(), 1.0, 1e-12);
}

}  // namespace
}  // namespace arborslam
