#include "frontend/projection/moving_object_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

using testing::IsEmpty;
using testing::StartsWith;

struct Disc {
  Eigen::Vector2d center;
  double radius;
  double density = 0.0;  // [1/m], of leaves; 0: solid.
};

// Where someone who walks has his two legs and his body, seen from above.
std::vector<Disc> Person(const SE2& place, double walked) {
  const double swing = 0.25 * std::sin(2.0 * kPi * walked / 0.9);
  return {{place * Eigen::Vector2d(swing, 0.1), 0.07},
          {place * Eigen::Vector2d(-swing, -0.1), 0.07},
          {place * Eigen::Vector2d(0.0, 0.0), 0.18}};
}

// A scan and, for each of its points, which disc it lies on.
struct Labelled {
  PlanarScan scan;
  std::vector<size_t> discs;
};

// Beams all around, half a degree apart, that end at the first disc, with 2 cm of noise; a tenth of them is lost, and
// those that meet nothing are free up to 15 m.
Labelled Measure(const std::vector<Disc>& discs, const SE2& T_world_base, double stamp, Random* random) {
  constexpr int kBeams = 720;
  Labelled result;
  result.scan.stamp = stamp;
  const SE2 T_base_world = T_world_base.Inverse();
  std::vector<Eigen::Vector2d> centers;
  for (const Disc& disc : discs) centers.push_back(T_base_world * disc.center);
  for (int beam = 0; beam < kBeams; ++beam) {
    const double bearing = -kPi + 2.0 * kPi * beam / kBeams;
    const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
    double range = 15.0;
    size_t hit = discs.size();
    for (size_t i = 0; i < discs.size(); ++i) {
      const double along = direction.dot(centers[i]);
      const double squared_half = discs[i].radius * discs[i].radius - (centers[i].squaredNorm() - along * along);
      if (squared_half <= 0.0 || along < 0.0) continue;
      const double half = std::sqrt(squared_half);
      double depth = along - half;
      if (discs[i].density > 0.0) depth += random->Exponential() / discs[i].density;
      if (depth > along + half || depth >= range) continue;
      range = depth;
      hit = i;
    }
    const double noise = 0.02 * random->Gaussian();
    if (random->Uniform() < 0.1) continue;
    if (hit == discs.size()) {
      result.scan.free_ends.push_back((range * direction).cast<float>());
    } else if (range > 0.3) {
      result.scan.points.push_back(((range + noise) * direction).cast<float>());
      result.discs.push_back(hit);
    }
  }
  return result;
}

// What became of the points of the standing discs and of the movers, within the range of the filter.
struct Rates {
  int num_standing = 0;
  int num_standing_rejected = 0;
  int num_moving = 0;
  int num_moving_rejected = 0;

  double Standing() const { return static_cast<double>(num_standing_rejected) / num_standing; }
  double Moving() const { return static_cast<double>(num_moving_rejected) / num_moving; }
};

struct Drive {
  double duration = 20.0;       // [s]
  double period = 0.1;          // [s] between scans.
  double count_from = 1.0;      // [s], before nothing is counted.
  double position_error = 0.0;  // [m], standard deviation of the prediction.
  double heading_error = 0.0;   // [rad]
};

using PoseAt = std::function<SE2(double)>;
using DiscsAt = std::function<std::vector<Disc>(double)>;

Rates RunFilter(const std::vector<Disc>& standing, const DiscsAt& movers, const PoseAt& pose, const Drive& drive,
                const MovingObjectOptions& options = {}) {
  Random random(17);
  MovingObjectFilter filter(options);
  Rates rates;
  for (int step = 0; step * drive.period < drive.duration; ++step) {
    const double time = step * drive.period;
    std::vector<Disc> discs = standing;
    for (const Disc& disc : movers(time)) discs.push_back(disc);
    const Labelled labelled = Measure(discs, pose(time), time, &random);
    const double dx = drive.position_error * random.Gaussian();
    const double dy = drive.position_error * random.Gaussian();
    const SE2 prediction = pose(time) * SE2(dx, dy, drive.heading_error * random.Gaussian());
    std::vector<bool> is_rejected(labelled.scan.points.size(), false);
    for (const MovingObject& object : filter.Find(labelled.scan, prediction)) {
      for (const size_t i : object.points) is_rejected[i] = true;
    }
    filter.Add(labelled.scan, pose(time));
    if (time < drive.count_from) continue;
    for (size_t i = 0; i < is_rejected.size(); ++i) {
      if (labelled.scan.points[i].norm() > options.range - 0.3) continue;
      const bool is_standing = labelled.discs[i] < standing.size();
      ++(is_standing ? rates.num_standing : rates.num_moving);
      if (is_rejected[i]) ++(is_standing ? rates.num_standing_rejected : rates.num_moving_rejected);
    }
  }
  return rates;
}

// Two rows of trunks along x with the lane between them at y = 0.
std::vector<Disc> Orchard() {
  Random random(3);
  std::vector<Disc> trunks;
  for (int i = -5; i <= 15; ++i) {
    for (const double y : {-6.6, -2.2, 2.2, 6.6}) {
      const double x = 2.0 * i + random.Uniform(-0.2, 0.2);
      trunks.push_back({{x, y + random.Uniform(-0.15, 0.15)}, random.Uniform(0.05, 0.12)});
    }
  }
  return trunks;
}

DiscsAt Nobody() {
  return [](double) { return std::vector<Disc>(); };
}

// Along the lane, swaying like someone who walks.
PoseAt AlongTheLane(double speed) {
  return [speed](double time) { return SE2(speed * time, 0.1 * std::sin(time), 0.05 * std::sin(2.0 * time)); };
}

// Someone who keeps `ahead` and `left` [m] of the robot, more or less.
DiscsAt Companion(double speed, double ahead, double left) {
  return [=](double time) {
    const double x = speed * time + ahead + 0.2 * std::sin(0.5 * time);
    return Person(SE2(x, left + 0.1 * std::sin(0.7 * time), 0.0), x);
  };
}

DiscsAt Both(const DiscsAt& one, const DiscsAt& other) {
  return [=](double time) {
    std::vector<Disc> discs = one(time);
    for (const Disc& disc : other(time)) discs.push_back(disc);
    return discs;
  };
}

TEST(MovingObjectFilterTest, TrunksStay) {
  for (const double speed : {0.3, 0.8, 1.5}) {
    for (const double period : {0.05, 0.1, 0.25}) {
      Drive drive;
      drive.period = period;
      drive.duration = 12.0;
      drive.position_error = 0.02;
      drive.heading_error = 0.01;
      const Rates rates = RunFilter(Orchard(), Nobody(), AlongTheLane(speed), drive);
      ASSERT_GT(rates.num_standing, 500);
      EXPECT_LT(rates.Standing(), 0.01) << speed << " m/s, every " << period << " s";
    }
  }
}

TEST(MovingObjectFilterTest, FindsFollowers) {
  for (const auto& [behind, left] : {std::pair(-1.2, 0.0), std::pair(-2.0, 0.5), std::pair(-3.5, -0.4)}) {
    for (const double speed : {0.6, 1.0, 1.5}) {
      Drive drive;
      drive.position_error = 0.02;
      drive.heading_error = 0.01;
      drive.count_from = 1.5;
      const Rates rates = RunFilter(Orchard(), Companion(speed, behind, left), AlongTheLane(speed), drive);
      ASSERT_GT(rates.num_moving, 500);
      EXPECT_GT(rates.Moving(), 0.9) << behind << " m, " << left << " m, " << speed << " m/s";
      EXPECT_LT(rates.Standing(), 0.01) << behind << " m, " << left << " m, " << speed << " m/s";
    }
  }
}

TEST(MovingObjectFilterTest, FindsSlowFollowersWithinSeconds) {
  Drive drive;
  drive.period = 0.25;
  drive.count_from = 3.0;
  const Rates rates = RunFilter(Orchard(), Companion(0.3, -1.5, 0.3), AlongTheLane(0.3), drive);
  EXPECT_GT(rates.Moving(), 0.9);
  EXPECT_LT(rates.Standing(), 0.01);
}

TEST(MovingObjectFilterTest, FindsTwoPeopleWhoWalkSideBySide) {
  const DiscsAt people = Both(Companion(0.8, -1.8, 0.35), Companion(0.8, -1.7, -0.35));
  Drive drive;
  drive.count_from = 1.5;
  const Rates rates = RunFilter(Orchard(), people, AlongTheLane(0.8), drive);
  EXPECT_GT(rates.Moving(), 0.9);
  EXPECT_LT(rates.Standing(), 0.01);
}

TEST(MovingObjectFilterTest, FindsWhoWalksAhead) {
  Drive drive;
  drive.count_from = 2.0;
  const Rates rates = RunFilter(Orchard(), Companion(0.8, 2.0, 0.1), AlongTheLane(0.8), drive);
  EXPECT_GT(rates.Moving(), 0.8);
  EXPECT_LT(rates.Standing(), 0.01);
}

TEST(MovingObjectFilterTest, FindsWhoCrossesWhetherTheRobotMovesOrStands) {
  const DiscsAt crossing = [](double time) {
    return Person(SE2(6.0, 4.0 - 1.2 * (time - 2.0), -0.5 * kPi), 1.2 * time);
  };
  Drive drive;
  drive.count_from = 3.0;
  drive.duration = 9.0;
  const Rates moving = RunFilter(Orchard(), crossing, AlongTheLane(0.8), drive);
  ASSERT_GT(moving.num_moving, 200);
  // Trunks hide a part of the way, and where he came from.
  EXPECT_GT(moving.Moving(), 0.8);
  EXPECT_LT(moving.Standing(), 0.01);
  const Rates standing = RunFilter(
      Orchard(), crossing, [](double) { return SE2(3.5, 0.0, 0.3); }, drive);
  ASSERT_GT(standing.num_moving, 200);
  EXPECT_GT(standing.Moving(), 0.8);
  EXPECT_LT(standing.Standing(), 0.01);
}

TEST(MovingObjectFilterTest, StandingOrTurningRobotsKeepEverything) {
  Drive drive;
  drive.position_error = 0.02;
  drive.heading_error = 0.01;
  const Rates standing = RunFilter(
      Orchard(), Nobody(), [](double) { return SE2(4.0, 0.3, 0.2); }, drive);
  EXPECT_LT(standing.Standing(), 0.005);
  const Rates turning = RunFilter(
      Orchard(), Nobody(), [](double time) { return SE2(4.0, 0.3, NormalizeAngle(0.8 * time)); }, drive);
  EXPECT_LT(turning.Standing(), 0.005);
}

TEST(MovingObjectFilterTest, PeopleWhoStandAreLeftAlone) {
  const DiscsAt person = [](double) { return Person(SE2(5.0, 0.8, 1.0), 0.1); };
  const Rates rates = RunFilter(
      Orchard(), person, [](double) { return SE2(3.0, 0.0, 0.0); }, Drive());
  ASSERT_GT(rates.num_moving, 500);
  EXPECT_EQ(rates.num_moving_rejected, 0) << "what does not move cannot be told from a post";
}

TEST(MovingObjectFilterTest, FoliageIsNotThrownOut) {
  std::vector<Disc> trees = Orchard();
  const size_t num_trunks = trees.size();
  Random random(8);
  for (size_t i = 0; i < num_trunks; ++i) {
    const Eigen::Vector2d offset(random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3));
    trees.push_back({trees[i].center + offset, random.Uniform(0.3, 0.7), random.Uniform(0.3, 3.0)});
  }
  for (const double speed : {0.0, 0.8}) {
    Drive drive;
    drive.position_error = 0.02;
    drive.heading_error = 0.01;
    const Rates rates = RunFilter(trees, Nobody(), AlongTheLane(speed), drive);
    ASSERT_GT(rates.num_standing, 1000);
    EXPECT_LT(rates.Standing(), 0.01) << speed << " m/s";
  }
}

TEST(MovingObjectFilterTest, PostsThatAreMissedInTurnsAreNotMovers) {
  // Low posts of which a rocking sensor sees each in one scan of three: all their places look free most of the time.
  Random random(5);
  std::vector<Disc> posts;
  for (int x = 0; x < 8; ++x) posts.push_back({{2.0 * x, x % 2 == 0 ? 1.5 : -1.5}, 0.1});
  std::vector<Disc> wall;
  for (int i = -200; i < 400; ++i) {
    wall.push_back({{0.1 * i, 6.0}, 0.08});
    wall.push_back({{0.1 * i, -6.0}, 0.08});
  }
  MovingObjectFilter filter{MovingObjectOptions()};
  int num_seen = 0;
  int num_rejected = 0;
  for (int step = 0; step < 150; ++step) {
    std::vector<Disc> seen = wall;
    for (const Disc& post : posts) {
      if (random.Uniform() < 0.33) seen.push_back(post);
    }
    const SE2 pose(0.08 * step, 0.0, 0.0);
    const Labelled labelled = Measure(seen, pose, 0.1 * step, &random);
    for (const size_t disc : labelled.discs) num_seen += disc >= wall.size() ? 1 : 0;
    for (const MovingObject& object : filter.Find(labelled.scan, pose)) {
      num_rejected += static_cast<int>(object.points.size());
    }
    filter.Add(labelled.scan, pose);
  }
  ASSERT_GT(num_seen, 1000);
  EXPECT_LT(num_rejected, 0.02 * num_seen);
}

TEST(MovingObjectFilterTest, WhatStandsWhereTheRobotWasCameAfterIt) {
  // Nothing around, no ray ends: only the robot's own path tells.
  MovingObjectFilter filter{MovingObjectOptions()};
  for (int step = 0; step < 50; ++step) {
    PlanarScan empty;
    empty.stamp = 0.1 * step;
    filter.Add(empty, SE2(0.1 * step, 0.0, 0.0));
  }
  PlanarScan scan;
  scan.stamp = 5.0;
  for (int i = 0; i < 10; ++i) {
    scan.points.emplace_back(-2.0f, -0.1f + 0.02f * static_cast<float>(i));
    scan.points.emplace_back(-2.0f, 1.0f + 0.02f * static_cast<float>(i));
  }
  const std::vector<MovingObject> objects = filter.Find(scan, SE2(5.0, 0.0, 0.0));
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_TRUE(objects[0].center.isApprox(Eigen::Vector2f(-2.0f, -0.01f), 1e-3f)) << objects[0].center.transpose();
  EXPECT_THAT(objects[0].points, testing::ElementsAre(0, 2, 4, 6, 8, 10, 12, 14, 16, 18));
  MovingObjectOptions options;
  options.body_radius = 0.0;
  MovingObjectFilter without_path(options);
  for (int step = 0; step < 50; ++step) {
    PlanarScan empty;
    empty.stamp = 0.1 * step;
    without_path.Add(empty, SE2(0.1 * step, 0.0, 0.0));
  }
  EXPECT_THAT(without_path.Find(scan, SE2(5.0, 0.0, 0.0)), IsEmpty());
}

TEST(MovingObjectFilterTest, AWrongPoseDoesNotThrowAwayTheWorld) {
  Random random(6);
  MovingObjectFilter filter{MovingObjectOptions()};
  for (int step = 0; step < 60; ++step) {
    const SE2 pose(4.0 + 0.05 * step, 0.0, 0.0);
    filter.Add(Measure(Orchard(), pose, 0.1 * step, &random).scan, pose);
  }
  const SE2 pose(7.0, 0.0, 0.0);
  const Labelled labelled = Measure(Orchard(), pose, 6.0, &random);
  for (const double heading : {0.2, 0.5, -0.4}) {
    size_t num_rejected = 0;
    for (const MovingObject& object : filter.Find(labelled.scan, pose * SE2(0.6, 0.5, heading))) {
      num_rejected += object.points.size();
    }
    EXPECT_LE(num_rejected, labelled.scan.points.size() / 4) << heading;
  }
}

TEST(MovingObjectFilterTest, FirstScansEmptyScansAndFewPoints) {
  Random random(7);
  const Labelled labelled = Measure(Orchard(), SE2(), 0.0, &random);
  MovingObjectFilter filter{MovingObjectOptions()};
  EXPECT_THAT(filter.Find(labelled.scan, SE2()), IsEmpty());
  filter.Add(labelled.scan, SE2());
  EXPECT_THAT(filter.Find(labelled.scan, SE2()), IsEmpty()) << "one scan is no history";
  for (int step = 1; step < 50; ++step) {
    PlanarScan empty;
    empty.stamp = 0.1 * step;
    EXPECT_THAT(filter.Find(empty, SE2()), IsEmpty());
    filter.Add(empty, SE2());
  }
  EXPECT_THAT(filter.Find(labelled.scan, SE2(0.0, 3.0, 0.0)), IsEmpty()) << "what was not seen before is not moving";
  PlanarScan few;
  few.stamp = 5.0;
  few.points = {{0.0f, 0.0f}, {1.0f, 0.0f}};
  EXPECT_THAT(filter.Find(few, SE2()), IsEmpty());
  filter.Add(few, SE2());
}

TEST(MovingObjectFilterTest, StampsThatStandStillOrRunBackDoNoHarm) {
  for (const double period : {0.0, -0.1, 100.0}) {
    Random random(9);
    MovingObjectFilter filter{MovingObjectOptions()};
    size_t num_rejected = 0;
    for (int step = 0; step < 40; ++step) {
      const SE2 pose = AlongTheLane(0.8)(0.1 * step);
      const Labelled labelled = Measure(Orchard(), pose, period * step, &random);
      for (const MovingObject& object : filter.Find(labelled.scan, pose)) num_rejected += object.points.size();
      filter.Add(labelled.scan, pose);
    }
    EXPECT_LT(num_rejected, 40u) << period;
  }
}

TEST(MovingObjectFilterTest, DisabledFindsNothing) {
  MovingObjectOptions options;
  options.enabled = false;
  const Rates rates = RunFilter(Orchard(), Companion(1.0, -1.5, 0.0), AlongTheLane(1.0), Drive(), options);
  EXPECT_EQ(rates.num_moving_rejected + rates.num_standing_rejected, 0);
}

TEST(WithoutMovingObjectsTest, TakesThePointsAndTheirWeightsOut) {
  PlanarScan scan;
  scan.stamp = 3.0;
  scan.points = {{1.0f, 0.0f}, {2.0f, 0.0f}, {3.0f, 0.0f}, {4.0f, 0.0f}};
  scan.weights = {1.0f, 2.0f, 3.0f, 4.0f};
  scan.free_ends = {{9.0f, 9.0f}};
  scan.first_returns = {{0.5f, 0.0f}};
  const std::vector<MovingObject> objects = {{{1.0f, 0.0f}, 0.1f, {0}}, {{3.0f, 0.0f}, 0.1f, {2}}};
  const PlanarScan rest = WithoutMovingObjects(scan, objects);
  EXPECT_EQ(rest.stamp, 3.0);
  EXPECT_THAT(rest.points, testing::ElementsAre(scan.points[1], scan.points[3]));
  EXPECT_THAT(rest.weights, testing::ElementsAre(2.0f, 4.0f));
  EXPECT_THAT(rest.first_returns, testing::ElementsAre(scan.first_returns[0]));
  EXPECT_THAT(rest.free_ends, testing::ElementsAre(scan.free_ends[0], scan.points[0], scan.points[2]));
  scan.point_rays_are_free = false;
  scan.weights.clear();
  const PlanarScan in_space = WithoutMovingObjects(scan, objects);
  EXPECT_FALSE(in_space.point_rays_are_free);
  EXPECT_THAT(in_space.free_ends, testing::ElementsAre(scan.free_ends[0]));
  EXPECT_THAT(in_space.weights, IsEmpty());
  EXPECT_EQ(WithoutMovingObjects(scan, {}).points, scan.points);
}

TEST(MovingObjectOptionsTest, NamesTheKeyThatIsOutOfRange) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(MovingObjectOptions().Validate(), "");
  const std::pair<const char*, std::function<void(MovingObjectOptions*)>> cases[] = {
      {"range", [](MovingObjectOptions* options) { options->range = 0.0; }},
      {"history", [](MovingObjectOptions* options) { options->history = kNan; }},
      {"max_size", [](MovingObjectOptions* options) { options->max_size = -1.0; }},
      {"range_margin", [](MovingObjectOptions* options) { options->range_margin = 0.0; }},
      {"side_margin", [](MovingObjectOptions* options) { options->side_margin = kNan; }},
      {"min_free_share", [](MovingObjectOptions* options) { options->min_free_share = 1.5; }},
      {"body_radius", [](MovingObjectOptions* options) { options->body_radius = -0.1; }},
      {"max_share", [](MovingObjectOptions* options) { options->max_share = 0.0; }},
  };
  for (const auto& [key, spoil] : cases) {
    MovingObjectOptions options;
    spoil(&options);
    EXPECT_THAT(options.Validate(), StartsWith(key));
  }
}

}  // namespace
}  // namespace arborslam
