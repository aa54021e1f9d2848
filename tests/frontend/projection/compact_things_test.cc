#include "frontend/projection/compact_things.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

// The visible side of a disc, seen from the origin in steps of 0.2 deg.
std::vector<Eigen::Vector2f> Disc(const Eigen::Vector2d& center, double radius, double noise, Random* random) {
  std::vector<Eigen::Vector2f> points;
  const double bearing = std::atan2(center.y(), center.x());
  for (double offset = -0.5; offset < 0.5; offset += DegToRad(0.2)) {
    const Eigen::Vector2d ray(std::cos(bearing + offset), std::sin(bearing + offset));
    const double along = ray.dot(center);
    const double squared = radius * radius - center.squaredNorm() + along * along;
    if (squared < 0.0) continue;
    points.push_back(((along - std::sqrt(squared) + noise * random->Gaussian()) * ray).cast<float>());
  }
  return points;
}

Eigen::Vector2d Mean(const std::vector<Eigen::Vector2f>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2f& point : points) mean += point.cast<double>() / static_cast<double>(points.size());
  return mean;
}

TEST(CenterCompactThings, PutsTrunksOnTheirAxisFromWhereverTheyAreSeen) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const double range = random.Uniform(1.5, 6.0);
    const double bearing = random.Uniform(-2.5, 2.5);
    const double radius = random.Uniform(0.06, 0.25);
    const Eigen::Vector2d center(range * std::cos(bearing), range * std::sin(bearing));
    PlanarScan scan;
    scan.points = Disc(center, radius, 0.01, &random);
    const size_t count = scan.points.size();
    const double before = (Mean(scan.points) - center).norm();
    CenterCompactThings(CompactThingOptions{}, &scan);
    ASSERT_EQ(scan.points.size(), count);
    EXPECT_GT(before, 0.6 * radius);
    EXPECT_LT((Mean(scan.points) - center).norm(), 0.2 * radius + 0.015);
  }
}

TEST(CenterCompactThings, LeavesWallsAndSinglePointsAlone) {
  PlanarScan scan;
  for (double y = -1.0; y <= 1.0; y += 0.03) scan.points.emplace_back(3.0f, static_cast<float>(y));
  scan.points.emplace_back(-4.0f, 1.0f);
  const std::vector<Eigen::Vector2f> before = scan.points;
  CenterCompactThings(CompactThingOptions{}, &scan);
  EXPECT_EQ(scan.points, before);
}

TEST(CenterCompactThings, TellsATrunkFromTheWallBehindIt) {
  Random random(2);
  // By bearing: the wall to both sides of the trunk, and the trunk.
  PlanarScan scan;
  for (double y = -2.0; y < -0.2; y += 0.03) scan.points.emplace_back(5.0f, static_cast<float>(y));
  const std::vector<Eigen::Vector2f> trunk = Disc({3.0, 0.0}, 0.1, 0.0, &random);
  const size_t first = scan.points.size();
  scan.points.insert(scan.points.end(), trunk.begin(), trunk.end());
  for (double y = 0.2; y < 2.0; y += 0.03) scan.points.emplace_back(5.0f, static_cast<float>(y));
  const PlanarScan before = scan;
  CenterCompactThings(CompactThingOptions{}, &scan);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const bool is_trunk = i >= first && i < first + trunk.size();
    if (is_trunk) {
      EXPECT_NEAR(scan.points[i].x(), 3.0f, 0.04f);
    } else {
      EXPECT_EQ(scan.points[i], before.points[i]);
    }
  }
}

TEST(CenterCompactThings, CanBeSwitchedOffAndTakesAnEmptyScan) {
  PlanarScan scan;
  CenterCompactThings(CompactThingOptions{}, &scan);
  EXPECT_TRUE(scan.points.empty());
  Random random(3);
  scan.points = Disc({2.0, 1.0}, 0.1, 0.0, &random);
  const std::vector<Eigen::Vector2f> before = scan.points;
  CompactThingOptions off;
  off.enabled = false;
  CenterCompactThings(off, &scan);
  EXPECT_EQ(scan.points, before);
}

// Single points, half a metre apart.
void AddSingles(int count, std::vector<Eigen::Vector2f>* points) {
  const auto first = static_cast<int>(points->size());
  for (int i = 0; i < count; ++i) {
    const double bearing = -2.0 + 0.05 * i;
    points->push_back((10.0 * Eigen::Vector2d(std::cos(bearing), std::sin(bearing))).cast<float>());
  }
  std::sort(points->begin() + first, points->end(), [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return std::atan2(a.y(), a.x()) < std::atan2(b.y(), b.x());
  });
}

TEST(ThinnedThings, NoThingHasMuchOfTheSay) {
  Random random(6);
  std::vector<Eigen::Vector2f> points;
  AddSingles(80, &points);
  // Two people, who follow close behind.
  for (const double y : {0.4, 2.0}) {
    const std::vector<Eigen::Vector2f> person = Disc({-1.5, y}, 0.2, 0.01, &random);
    ASSERT_GT(person.size(), 40u);
    points.insert(points.end(), person.begin(), person.end());
  }
  const std::vector<Eigen::Vector2f> thinned = ThinnedThings(CompactThingOptions{}, points);
  ASSERT_LT(thinned.size(), points.size());
  EXPECT_TRUE(std::equal(points.begin(), points.begin() + 80, thinned.begin()));
  const size_t rest = thinned.size() - 80;
  EXPECT_LE(rest, 2 * thinned.size() / 10);
  EXPECT_GE(rest, 16u);
  // They are taken from all of the thing.
  const Eigen::Vector2f breadth = thinned[80] - thinned[80 + rest / 2 - 1];
  EXPECT_GT(breadth.norm(), 0.25f);
}

TEST(ThinnedThings, LeavesWallsAndScansOfManyThingsAlone) {
  Random random(7);
  std::vector<Eigen::Vector2f> wall;
  for (double y = -1.0; y <= 1.0; y += 0.01) wall.emplace_back(3.0f, static_cast<float>(y));
  EXPECT_EQ(ThinnedThings(CompactThingOptions{}, wall), wall);
  std::vector<Eigen::Vector2f> trunks;
  for (double bearing = -2.8; bearing < 3.0; bearing += 0.4) {
    const std::vector<Eigen::Vector2f> trunk =
        Disc({4.0 * std::cos(bearing), 4.0 * std::sin(bearing)}, 0.1, 0.01, &random);
    trunks.insert(trunks.end(), trunk.begin(), trunk.end());
  }
  EXPECT_EQ(ThinnedThings(CompactThingOptions{}, trunks), trunks);
}

TEST(ThinnedThings, KeepsEnoughToMatchWithAndCanBeSwitchedOff) {
  Random random(8);
  std::vector<Eigen::Vector2f> points;
  AddSingles(10, &points);
  const std::vector<Eigen::Vector2f> person = Disc({-1.0, 0.3}, 0.25, 0.01, &random);
  ASSERT_GT(person.size(), 100u);
  points.insert(points.end(), person.begin(), person.end());
  EXPECT_EQ(ThinnedThings(CompactThingOptions{}, points).size(), 50u);
  CompactThingOptions off;
  off.enabled = false;
  EXPECT_EQ(ThinnedThings(off, points), points);
  EXPECT_TRUE(ThinnedThings(CompactThingOptions{}, {}).empty());
}

TEST(CompactThingOptions, RefusesWhatMakesNoSense) {
  CompactThingOptions options;
  EXPECT_EQ(options.Validate(), "");
  options.max_width = -1.0;
  EXPECT_NE(options.Validate().find("max_width"), std::string::npos);
  options = CompactThingOptions{};
  options.max_gap = 3.0;
  EXPECT_NE(options.Validate().find("max_gap"), std::string::npos);
  options = CompactThingOptions{};
  options.max_share = 0.0;
  EXPECT_NE(options.Validate().find("max_share"), std::string::npos);
}

}  // namespace
}  // namespace arborslam
