#include "frontend/matching/match_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "core/geometry/angles.h"
#include "core/simulation/planar_corridor.h"
#include "core/simulation/random.h"
#include "frontend/matching/matcher.h"
#include "frontend/matching/refinement.h"
#include "tests/frontend/simulated_run.h"

namespace arborslam {
namespace {

const SearchWindow kWindow{0.5, 0.2, 0.01, {}};

Matcher DefaultMatcher() { return Matcher(MatcherOptions(), MhdOptions(), RefinementOptions()); }

// Normalised estimation error squared, per degree of freedom; 1 on average when the information is honest.
double Nees(const SE2& estimate, const SE2& truth, const Eigen::Matrix3d& information) {
  const Eigen::Vector3d error = (estimate.Inverse() * truth).vector();
  return error.dot(information * error) / 3.0;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

struct NeesOfMatches {
  std::vector<double> nees;
  int num_matches = 0;
  int num_degenerate = 0;
};

// Matches scans of default orchards to maps of the `map_scans` scans before them, from poses that are off.
NeesOfMatches MatchInOrchards(size_t map_scans) {
  // So many scans follow each map that are matched to it.
  constexpr size_t kMatchesPerMap = 8;
  NeesOfMatches result;
  const Matcher matcher = DefaultMatcher();
  for (int seed = 1; seed <= 5; ++seed) {
    PlanarOrchardOptions options;
    options.seed = seed;
    const PlanarOrchard orchard(options);
    std::vector<PlanarScan> scans;
    std::vector<SE2> poses;
    for (size_t i = 0; i < orchard.NumScans(); ++i) {
      if (orchard.IsSpoilt(i)) continue;
      scans.push_back(ProjectLaserScan(orchard.Scan(i), ProjectionOptions()));
      poses.push_back(orchard.TruePose(i));
    }
    Random random(static_cast<uint64_t>(seed), map_scans);
    for (size_t first = 0; first + map_scans + kMatchesPerMap <= scans.size(); first += 32) {
      OccupancyGrid grid{OccupancyGridOptions()};
      size_t index = first;
      for (; index < first + map_scans; ++index) grid.Insert(poses[index], scans[index]);
      const MatchTarget target = TargetOf(grid);
      for (; index < first + map_scans + kMatchesPerMap; ++index) {
        const SE2 prediction =
            poses[index] * SE2(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3), random.Uniform(-0.1, 0.1));
        const MatchResult match = matcher.Match(target, scans[index].points, prediction, kWindow);
        ++result.num_matches;
        result.num_degenerate += match.num_degenerate > 0;
        if (match.verdict == MatchVerdict::kAccepted) {
          result.nees.push_back(Nees(match.pose, poses[index], match.information));
        }
      }
    }
  }
  return result;
}

class MatchCovarianceInOrchardsTest : public testing::TestWithParam<size_t> {};

TEST_P(MatchCovarianceInOrchardsTest, IsHonest) {
  const NeesOfMatches result = MatchInOrchards(GetParam());
  RecordProperty("mean_nees", std::to_string(Mean(result.nees)));
  ASSERT_GE(result.nees.size(), 500u);
  EXPECT_GE(result.nees.size(), static_cast<size_t>(0.98 * result.num_matches));
  // An orchard determines the whole pose; where the search goes astray along a hedge, the place it ends at may not.
  EXPECT_LE(result.num_degenerate, result.num_matches / 200);
  const double mean = Mean(result.nees);
  EXPECT_GT(mean, 0.5);
  EXPECT_LT(mean, 2.0);
  // Of chi squared with three degrees of freedom: 0.79.
  const double median = Median(result.nees);
  EXPECT_GT(median, 0.4);
  EXPECT_LT(median, 1.6);
  std::cout << "maps of " << GetParam() << " scans, " << result.nees.size() << " matches: NEES " << mean << ", median "
            << median << "\n";
}

INSTANTIATE_TEST_SUITE_P(MapsOfScans, MatchCovarianceInOrchardsTest, testing::Values(5, 20, 60));

// A textbook case: points scattered about posts that are far apart is linear least squares.
TEST(MatchCovarianceTest, IsThatOfLeastSquaresOnPosts) {
  std::mt19937 random(31);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::uniform_real_distribution<float> off(-0.1f, 0.1f);
  std::vector<OccupiedCell> cells;
  for (int x = -5; x <= 5; ++x) {
    for (int y = -5; y <= 5; ++y) {
      cells.push_back(
          {Eigen::Vector2f(static_cast<float>(x) + off(random), static_cast<float>(y) + off(random)), 1.0f});
    }
  }
  const MatchTarget target(cells, 0.05, kTestMaxDistance);
  std::vector<double> nees;
  Eigen::Matrix3d mean_information = Eigen::Matrix3d::Zero();
  constexpr int kTrials = 500;
  for (int trial = 0; trial < kTrials; ++trial) {
    const SE2 truth(0.3, -0.2, 0.01 * trial);
    std::vector<Eigen::Vector2f> points;
    for (const OccupiedCell& cell : cells) {
      const Eigen::Vector2d seen = cell.centroid.cast<double>() + Eigen::Vector2d(noise(random), noise(random));
      points.push_back((truth.Inverse() * seen).cast<float>());
    }
    const RefinementResult result = Refine(target, points, truth, truth, MhdOptions(), RefinementOptions());
    nees.push_back(Nees(result.pose, truth, result.information));
    mean_information += result.information / kTrials;
  }
  EXPECT_GT(Mean(nees), 0.5);
  EXPECT_LT(Mean(nees), 1.5);
  // 121 points of 1 cm, of which the best four fifths are used.
  const double of_all = 121.0 / (0.01 * 0.01);
  EXPECT_GT(mean_information(0, 0), 0.3 * of_all);
  EXPECT_LT(mean_information(0, 0), 1.5 * of_all);
  EXPECT_NEAR(mean_information(1, 1) / mean_information(0, 0), 1.0, 0.3);
  // Mean square distance of the posts from the base, 20 m^2, is what a turn has over a shift in x and y.
  EXPECT_NEAR(mean_information(2, 2) / (mean_information(0, 0) * 20.0), 1.0, 0.4);
}

TEST(MatchCovarianceTest, IsExpressedInTheFrameOfTheBase) {
  // Two rows of posts along the target's x, seen from between them: x and y are known alike, but the rows' far ends
  // hold the turn; the base looks along -y. Noise across the rows only, so that y [target] is known worse than x.
  std::mt19937 random(32);
  std::normal_distribution<double> noise(0.0, 0.02);
  std::vector<OccupiedCell> cells;
  for (int x = -8; x <= 8; ++x) {
    for (const float y : {-1.96f, 2.03f}) cells.push_back({Eigen::Vector2f(static_cast<float>(x) + 0.02f, y), 1.0f});
  }
  const MatchTarget target(cells, 0.05, kTestMaxDistance);
  const SE2 truth(0.0, 0.0, -0.5 * kPi);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<Eigen::Vector2f> points;
    for (const OccupiedCell& cell : cells) {
      const Eigen::Vector2d seen = cell.centroid.cast<double>() + Eigen::Vector2d(0.1 * noise(random), noise(random));
      points.push_back((truth.Inverse() * seen).cast<float>());
    }
    covariance += Refine(target, points, truth, truth, MhdOptions(), RefinementOptions()).information.inverse() / 100.0;
  }
  EXPECT_GT(covariance(0, 0), 9.0 * covariance(1, 1)) << "target y is the base's -x";
}

TEST(MatchCovarianceTest, TooFewPatchesOrDirectionsGiveNothing) {
  const MatchTarget target({{Eigen::Vector2f(1.0f, 1.0f), 1.0f}, {Eigen::Vector2f(1.1f, 1.0f), 1.0f}}, 0.05,
                           kTestMaxDistance);
  const std::vector<Eigen::Vector2f> points(100, Eigen::Vector2f(1.01f, 1.01f));
  const MatchCovarianceOptions options{0.05, 0.05};
  const Eigen::Matrix3d all = Eigen::Matrix3d::Identity();
  EXPECT_TRUE(MatchInformation(target, points, SE2(), MhdOptions(), options, 5.0, all).isZero());
  EXPECT_TRUE(MatchInformation(target, {}, SE2(), MhdOptions(), options, 5.0, all).isZero());
  EXPECT_TRUE(MatchInformation(MatchTarget({}, 0.05, 0.2), points, SE2(), MhdOptions(), options, 5.0, all).isZero());
  EXPECT_TRUE(MatchInformation(target, points, SE2(), MhdOptions(), options, 5.0, all.leftCols(0)).isZero());
}

TEST(MatchCovarianceTest, PointsAtTheBaseDoNoHarm) {
  std::mt19937 random(33);
  std::uniform_real_distribution<float> place(-6.0f, 6.0f);
  std::vector<OccupiedCell> cells = {{Eigen::Vector2f::Zero(), 1.0f}};
  std::vector<Eigen::Vector2f> points = {Eigen::Vector2f::Zero()};
  for (int i = 0; i < 60; ++i) {
    points.emplace_back(place(random), place(random));
    cells.push_back({points.back(), 1.0f});
  }
  const MatchTarget target(cells, 0.05, kTestMaxDistance);
  const Eigen::Matrix3d information = MatchInformation(target, points, SE2(0.01, 0.0, 0.0), MhdOptions(), {0.05, 0.05},
                                                       5.0, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(information.allFinite());
  EXPECT_GT(information(0, 0), 0.0);
}

TEST(MatchCovarianceTest, ACorridorIsUnknownAlongItself) {
  for (const auto& [width, roughness] : {std::pair(3.0, 0.0), std::pair(2.0, 0.05), std::pair(6.0, 0.0)}) {
    PlanarCorridorOptions options;
    options.width = width;
    options.roughness = roughness;
    const PlanarCorridor corridor(options);
    const MatchTarget target = TargetOf(MapOf(corridor, 0, 20));
    const Matcher matcher = DefaultMatcher();
    Random random(3);
    for (size_t index = 20; index < 60; ++index) {
      SCOPED_TRACE(testing::Message() << "width " << width << ", scan " << index);
      // The corridor looks the same from everywhere: the scan might as well have been taken here.
      const SE2 truth = SE2(2.0 + 0.05 * static_cast<double>(index), 0.0, 0.0);
      const SE2 prediction =
          truth * SE2(random.Uniform(-0.3, 0.3), random.Uniform(-0.2, 0.2), random.Uniform(-0.05, 0.05));
      const std::vector<Eigen::Vector2f> points = PointsOf(corridor, index);
      const MatchResult match = matcher.Match(target, points, prediction, kWindow);
      ASSERT_EQ(match.verdict, MatchVerdict::kDegenerate);
      EXPECT_EQ(match.num_degenerate, 1);
      const RefinementResult refined =
          Refine(target, points, match.pose, prediction, MhdOptions(), RefinementOptions());
      EXPECT_GT(std::abs(refined.degenerate_basis(0, 0)), 0.98) << "the base looks along the corridor";
      EXPECT_NEAR(match.pose.x(), prediction.x(), roughness > 0.0 ? 0.05 : 0.02)
          << "along the corridor only the prediction knows";
      EXPECT_NEAR(match.pose.y(), 0.0, 0.02);
      EXPECT_NEAR(match.pose.theta(), 0.0, 0.004);
      EXPECT_LT(match.information(0, 0), 1e-2 * match.information(1, 1));
      EXPECT_GT(match.information(1, 1), 1.0 / (0.05 * 0.05)) << "across it the walls do";
    }
  }
}

}  // namespace
}  // namespace arborslam
