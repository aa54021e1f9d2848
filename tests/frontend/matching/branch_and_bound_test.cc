#include "frontend/matching/branch_and_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kCell = 0.1;         // [m]
constexpr double kMaxDistance = 0.5;  // [m]

struct World {
  std::vector<OccupiedCell> cells;
  std::vector<Eigen::Vector2f> points;
  SE2 center;
  SearchWindow window;
  MhdOptions mhd;
};

// Every pose of the window's grid, by its definition.
std::vector<SE2> Grid(const World& world) {
  const int half_cells = static_cast<int>(std::floor(world.window.translation / kCell + 1e-6));
  const int half_turns = static_cast<int>(std::floor(world.window.rotation / world.window.rotation_step + 1e-6));
  std::vector<SE2> poses;
  for (int turn = -half_turns; turn <= half_turns; ++turn) {
    for (int x = -half_cells; x <= half_cells; ++x) {
      for (int y = -half_cells; y <= half_cells; ++y) {
        poses.emplace_back(world.center.x() + x * kCell, world.center.y() + y * kCell,
                           world.center.theta() + turn * world.window.rotation_step);
      }
    }
  }
  return poses;
}

// The cost of a pose by its definition, on quantised distances [m].
double Cost(const World& world, const DistanceField& field, const std::vector<uint8_t>& quantised, const SE2& pose) {
  std::vector<int> steps;
  for (const Eigen::Vector2f& point : world.points) {
    const Eigen::Vector2d position = pose * point.cast<double>();
    const int x = static_cast<int>(std::floor(position.x() / kCell)) - field.first_x();
    const int y = static_cast<int>(std::floor(position.y() / kCell)) - field.first_y();
    const bool inside = x >= 0 && y >= 0 && x < field.width() && y < field.height();
    steps.push_back(inside ? quantised[static_cast<size_t>(x * field.height() + y)] : MinPyramid::kNumSteps);
  }
  std::sort(steps.begin(), steps.end());
  const auto near = std::count_if(steps.begin(), steps.end(), [](int step) { return step < MinPyramid::kNumSteps; });
  const int k = ChooseK(static_cast<int>(near), static_cast<int>(steps.size()), world.mhd);
  double sum = 0.0;
  for (int i = 0; i < k; ++i) sum += steps[static_cast<size_t>(i)];
  const SE2 motion = world.center.Inverse() * pose;
  return sum / k * kMaxDistance / MinPyramid::kNumSteps +
         world.window.penalty.per_metre * std::hypot(motion.x(), motion.y()) +
         world.window.penalty.per_radian * std::abs(motion.theta());
}

bool IsExcluded(const SE2& pose, const Exclusion& exclusion) {
  return (pose.translation() - exclusion.pose.translation()).norm() < exclusion.translation &&
         std::abs(AngleDifference(pose.theta(), exclusion.pose.theta())) < exclusion.rotation;
}

struct Exhaustive {
  double cost = std::numeric_limits<double>::infinity();
  std::vector<SE2> poses;  // All that have it.
};

Exhaustive SearchAll(const World& world, const MatchTarget& target, const std::optional<Exclusion>& exclusion) {
  const std::vector<uint8_t> quantised = target.field().Quantised(MinPyramid::kNumSteps);
  Exhaustive best;
  for (const SE2& pose : Grid(world)) {
    if (exclusion && IsExcluded(pose, *exclusion)) continue;
    const double cost = Cost(world, target.field(), quantised, pose);
    if (cost < best.cost - 1e-9) best = {cost, {}};
    if (cost < best.cost + 1e-9) best.poses.push_back(pose);
  }
  return best;
}

// A few clumps of cells, and points that in part stem from them.
World RandomWorld(std::mt19937* random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(*random);
  };
  World world;
  world.center = SE2(uniform(-20.0, 20.0), uniform(-20.0, 20.0), uniform(-kPi, kPi));
  world.window.translation = uniform(0.05, 1.0);
  world.window.rotation = uniform(0.0, 0.15);
  world.window.rotation_step = uniform(0.02, 0.06);
  if (uniform(0.0, 1.0) < 0.3) {
    world.mhd.alpha_min = uniform(0.2, 1.0);
    world.mhd.alpha_max = uniform(world.mhd.alpha_min, 1.0);
  }
  if (uniform(0.0, 1.0) < 0.5) world.window.penalty = {uniform(0.0, 0.2), uniform(0.0, 0.5)};
  const SE2 truth = world.center * SE2(uniform(-0.8, 0.8), uniform(-0.8, 0.8), uniform(-0.15, 0.15));
  const int num_points = std::uniform_int_distribution<int>(1, 25)(*random);
  for (int i = 0; i < num_points; ++i) {
    const Eigen::Vector2f point(static_cast<float>(uniform(-4.0, 4.0)), static_cast<float>(uniform(-4.0, 4.0)));
    world.points.push_back(point);
    if (uniform(0.0, 1.0) < 0.25) continue;
    const Eigen::Vector2d noise(uniform(-0.1, 0.1), uniform(-0.1, 0.1));
    world.cells.push_back({(truth * point.cast<double>() + noise).cast<float>(), 1.0f});
  }
  const int num_clutter = std::uniform_int_distribution<int>(1, 30)(*random);
  for (int i = 0; i < num_clutter; ++i) {
    world.cells.push_back(
        {(world.center * Eigen::Vector2d(uniform(-5.0, 5.0), uniform(-5.0, 5.0))).cast<float>(), 1.0f});
  }
  // Points that come to lie on the border of a cell may fall to either side by rounding: leave these out.
  const auto is_clear = [&](const Eigen::Vector2f& point) {
    const int half_turns = static_cast<int>(std::floor(world.window.rotation / world.window.rotation_step + 1e-6));
    for (int turn = -half_turns; turn <= half_turns; ++turn) {
      const SE2 pose(world.center.x(), world.center.y(), world.center.theta() + turn * world.window.rotation_step);
      const Eigen::Vector2d cell = pose * point.cast<double>() / kCell;
      if ((cell - cell.array().round().matrix()).cwiseAbs().minCoeff() < 3e-4) return false;
    }
    return true;
  };
  std::vector<Eigen::Vector2f> clear;
  for (const Eigen::Vector2f& point : world.points) {
    if (is_clear(point)) clear.push_back(point);
  }
  world.points = clear;
  return world;
}

void ExpectTheBest(const World& world, const MatchTarget& target, const std::optional<SearchResult>& found,
                   const Exhaustive& best) {
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->cost, best.cost, 1e-6);
  const bool is_one_of_them = std::any_of(best.poses.begin(), best.poses.end(),
                                          [&](const SE2& pose) { return pose.IsApprox(found->pose, 1e-6); });
  EXPECT_TRUE(is_one_of_them) << best.poses.size() << " poses cost least, but not " << found->pose;
  const std::vector<uint8_t> quantised = target.field().Quantised(MinPyramid::kNumSteps);
  EXPECT_NEAR(Cost(world, target.field(), quantised, found->pose), found->cost, 1e-6);
}

TEST(BranchAndBoundTest, FindsWhatExhaustiveSearchFinds) {
  std::mt19937 random(11);
  int num_unique = 0;
  int num_tried = 0;
  for (int trial = 0; trial < 400; ++trial) {
    SCOPED_TRACE(trial);
    const World world = RandomWorld(&random);
    if (world.points.empty()) continue;
    const MatchTarget target(world.cells, kCell, kMaxDistance);
    const Exhaustive best = SearchAll(world, target, std::nullopt);
    const auto found =
        BranchAndBound(target, world.points, world.center, world.window, world.mhd, kMaxDistance + 1.0, std::nullopt);
    ExpectTheBest(world, target, found, best);
    num_unique += best.poses.size() == 1;
    ++num_tried;
  }
  EXPECT_GT(num_tried, 350);
  EXPECT_GT(num_unique, 100) << "the worlds should mostly have one best pose";
}

TEST(BranchAndBoundTest, FindsTheBestOutsideAnExclusion) {
  std::mt19937 random(12);
  int num_moved = 0;
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    const World world = RandomWorld(&random);
    if (world.points.empty()) continue;
    const MatchTarget target(world.cells, kCell, kMaxDistance);
    const Exhaustive all = SearchAll(world, target, std::nullopt);
    const Exclusion exclusion{all.poses.front(), 0.25, 0.05};
    const Exhaustive best = SearchAll(world, target, exclusion);
    const auto found =
        BranchAndBound(target, world.points, world.center, world.window, world.mhd, kMaxDistance + 1.0, exclusion);
    if (best.poses.empty()) {
      EXPECT_FALSE(found.has_value());
      continue;
    }
    ExpectTheBest(world, target, found, best);
    EXPECT_FALSE(IsExcluded(found->pose, exclusion));
    num_moved += best.cost > all.cost;
  }
  EXPECT_GT(num_moved, 50);
}

TEST(BranchAndBoundTest, AnyPoseOutsideAnExclusionWillDoIfSaid) {
  std::mt19937 random(15);
  int num_better = 0;
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    const World world = RandomWorld(&random);
    if (world.points.empty()) continue;
    const MatchTarget target(world.cells, kCell, kMaxDistance);
    const Exhaustive all = SearchAll(world, target, std::nullopt);
    const Exclusion exclusion{all.poses.front(), 0.25, 0.05, true};
    const Exhaustive best = SearchAll(world, target, exclusion);
    const double max_cost = all.cost + 0.05;
    const auto found = BranchAndBound(target, world.points, world.center, world.window, world.mhd, max_cost, exclusion);
    ASSERT_EQ(found.has_value(), best.cost < max_cost - 1e-9);
    if (!found) continue;
    EXPECT_FALSE(IsExcluded(found->pose, exclusion));
    EXPECT_LT(found->cost, max_cost);
    const std::vector<uint8_t> quantised = target.field().Quantised(MinPyramid::kNumSteps);
    EXPECT_NEAR(Cost(world, target.field(), quantised, found->pose), found->cost, 1e-6);
    num_better += best.cost < found->cost - 1e-6;
  }
  EXPECT_GT(num_better, 5) << "otherwise the best was found all the same";
}

struct SeenCost {
  double cost;       // [m]
  double core_cost;  // [m]
  int num_used;
};

// By their definition.
SeenCost CostOfSeen(const World& world, const SeenOnly& seen_only, const SE2& pose) {
  std::vector<int> steps;
  int num_seen = 0;
  for (const Eigen::Vector2f& point : world.points) {
    const Eigen::Vector2d position = pose * point.cast<double>();
    const int value = seen_only.pyramid->level(0).At(
        static_cast<int>(std::floor(position.x() / kCell)) - seen_only.pyramid->first_x(),
        static_cast<int>(std::floor(position.y() / kCell)) - seen_only.pyramid->first_y());
    num_seen += value < MinPyramid::kUnseen ? 1 : 0;
    steps.push_back(std::min(value, MinPyramid::kNumSteps));
  }
  std::sort(steps.begin(), steps.end());
  const auto num_near = static_cast<int>(
      std::count_if(steps.begin(), steps.end(), [](int step) { return step < MinPyramid::kNumSteps; }));
  const auto num_points = static_cast<int>(steps.size());
  int k = ChooseK(num_near, num_seen, world.mhd);
  if (k <= num_near) k = std::min(k, seen_only.max_near);
  const int by_share = std::max(1, static_cast<int>(std::ceil(seen_only.min_share * num_points - 1e-9)));
  const int least_k = std::min(by_share, ChooseK(0, num_points, world.mhd));
  k = std::max(k, least_k);
  const auto mean_of_least = [&steps](int count) {
    return std::accumulate(steps.begin(), steps.begin() + count, 0.0) / count * kMaxDistance / MinPyramid::kNumSteps;
  };
  const SE2 motion = world.center.Inverse() * pose;
  const double penalty = world.window.penalty.per_metre * std::hypot(motion.x(), motion.y()) +
                         world.window.penalty.per_radian * std::abs(motion.theta());
  return {mean_of_least(k) + penalty, mean_of_least(least_k), k};
}

TEST(BranchAndBoundTest, FindsWhatExhaustiveSearchByWhatWasSeenFinds) {
  std::mt19937 random(16);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int num_other = 0;
  int num_none = 0;
  for (int trial = 0; trial < 400; ++trial) {
    SCOPED_TRACE(trial);
    const World world = RandomWorld(&random);
    if (world.points.empty()) continue;
    const MatchTarget target(world.cells, kCell, kMaxDistance);
    OccupancyGridOptions grid_options;
    grid_options.cell_size = 2.0 * kCell;
    OccupancyGrid grid(grid_options);
    PlanarScan scan;
    for (double angle = 0.0; angle < 4.0; angle += 0.05) {
      const double range = uniform(2.0, 6.0);
      scan.free_ends.emplace_back(range * std::cos(angle), range * std::sin(angle));
    }
    grid.Insert(world.center, scan);
    MinPyramid pyramid(target.field(), FreeArea(grid), 1);
    SeenOnly seen_only{&pyramid, uniform(0.1, 1.0)};
    if (trial % 2 == 1) seen_only.max_near = std::uniform_int_distribution<int>(1, 20)(random);
    if (trial % 3 == 2) seen_only.max_core_cost = uniform(0.05, 0.3);
    double least = std::numeric_limits<double>::infinity();
    for (const SE2& pose : Grid(world)) {
      const SeenCost at_pose = CostOfSeen(world, seen_only, pose);
      if (at_pose.core_cost < seen_only.max_core_cost) least = std::min(least, at_pose.cost);
    }
    const auto found = BranchAndBound(target, world.points, world.center, world.window, world.mhd, kMaxDistance + 1.0,
                                      std::nullopt, seen_only);
    ASSERT_EQ(found.has_value(), std::isfinite(least));
    if (!found) {
      ++num_none;
      continue;
    }
    EXPECT_NEAR(found->cost, least, 1e-6);
    const SeenCost at_found = CostOfSeen(world, seen_only, found->pose);
    EXPECT_NEAR(found->cost, at_found.cost, 1e-6);
    EXPECT_NEAR(found->core_cost, at_found.core_cost, 1e-6);
    EXPECT_EQ(found->num_used, at_found.num_used);
    num_other += std::abs(SearchAll(world, target, std::nullopt).cost - least) > 1e-3;
  }
  EXPECT_GT(num_other, 100) << "it should matter what was seen";
  EXPECT_GT(num_none, 10) << "some cores should fit nowhere";
}

TEST(BranchAndBoundTest, AnExclusionOfTheWholeWindowLeavesNothing) {
  std::mt19937 random(13);
  const World world = RandomWorld(&random);
  const MatchTarget target(world.cells, kCell, kMaxDistance);
  EXPECT_FALSE(BranchAndBound(target, world.points, world.center, world.window, world.mhd, 10.0,
                              Exclusion{world.center, 100.0, 4.0}));
}

TEST(BranchAndBoundTest, FindsNothingThatDoesNotBeatTheMaxCost) {
  std::mt19937 random(14);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const World world = RandomWorld(&random);
    if (world.points.empty()) continue;
    const MatchTarget target(world.cells, kCell, kMaxDistance);
    const Exhaustive best = SearchAll(world, target, std::nullopt);
    const auto search = [&](double max_cost) {
      return BranchAndBound(target, world.points, world.center, world.window, world.mhd, max_cost);
    };
    EXPECT_FALSE(search(best.cost - 1e-5));
    const auto found = search(best.cost + 1e-5);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->cost, best.cost, 1e-6);
  }
}

TEST(BranchAndBoundTest, EmptyPointsOrTargetGiveNothing) {
  const MatchTarget target({{Eigen::Vector2f(1.0f, 1.0f), 1.0f}}, kCell, kMaxDistance);
  const MatchTarget nothing({}, kCell, kMaxDistance);
  const std::vector<Eigen::Vector2f> points = {Eigen::Vector2f(1.0f, 1.0f)};
  EXPECT_FALSE(BranchAndBound(target, {}, SE2(), SearchWindow(), MhdOptions(), 1.0));
  EXPECT_FALSE(BranchAndBound(nothing, points, SE2(), SearchWindow(), MhdOptions(), 1.0));
  EXPECT_TRUE(BranchAndBound(target, points, SE2(), SearchWindow(), MhdOptions(), 1.0));
}

TEST(BranchAndBoundTest, OnePointIsPutOnTheOnlyCell) {
  const MatchTarget target({{Eigen::Vector2f(1.05f, 2.05f), 1.0f}}, kCell, kMaxDistance);
  const auto found = BranchAndBound(target, {Eigen::Vector2f(0.74f, 2.36f)}, SE2(), SearchWindow{0.5, 0.0, 0.01, {}},
                                    MhdOptions(), 1.0);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->cost, 0.0);
  EXPECT_TRUE(found->pose.IsApprox(SE2(0.3, -0.3, 0.0), 1e-6)) << found->pose;
}

TEST(BranchAndBoundTest, AWindowOfOnePoseIsScored) {
  const MatchTarget target({{Eigen::Vector2f(1.05f, 2.05f), 1.0f}}, kCell, kMaxDistance);
  const SE2 center(0.3, -0.3, 0.0);
  const auto found = BranchAndBound(target, {Eigen::Vector2f(0.74f, 2.36f)}, center,
                                    SearchWindow{0.01, 0.001, 0.01, {}}, MhdOptions(), 1.0);
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(found->pose.IsApprox(center));
}

TEST(BranchAndBoundTest, ThePenaltyDecidesBetweenEquals) {
  // Two cells, one point between them, nearer to the second.
  const MatchTarget target({{Eigen::Vector2f(1.05f, 0.05f), 1.0f}, {Eigen::Vector2f(-0.55f, 0.05f), 1.0f}}, kCell,
                           kMaxDistance);
  const std::vector<Eigen::Vector2f> point = {Eigen::Vector2f(0.05f, 0.05f)};
  const auto found = BranchAndBound(target, point, SE2(), SearchWindow{1.2, 0.0, 0.01, {0.01, 0.0}}, MhdOptions(), 1.0);
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(found->pose.IsApprox(SE2(-0.6, 0.0, 0.0), 1e-6)) << found->pose;
  EXPECT_NEAR(found->cost, 0.006, 1e-6);
  EXPECT_NEAR(PenaltyOf(SE2(3.0, 4.0, 0.0), SE2(), {0.1, 1.0}), 0.5, 1e-12);
  EXPECT_NEAR(PenaltyOf(SE2(0.0, 0.0, 3.1), SE2(0.0, 0.0, -3.1), {0.1, 1.0}), 2.0 * kPi - 6.2, 1e-9);
}

TEST(BranchAndBoundTest, ScoresFarFewerThanAllPoses) {
  std::mt19937 random(15);
  std::uniform_real_distribution<float> place(-8.0f, 8.0f);
  World world;
  for (int i = 0; i < 100; ++i) {
    world.points.emplace_back(place(random), place(random));
    world.cells.push_back({world.points.back(), 1.0f});
  }
  const MatchTarget target(world.cells, kCell, kMaxDistance);
  world.window = {2.0, 0.5, 0.02, {}};
  const SE2 truth(0.7, -0.4, 0.2);
  const auto found = BranchAndBound(target, world.points, truth, world.window, world.mhd, kMaxDistance);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(found->pose.translation().norm(), 0.15);
  EXPECT_LT(std::abs(found->pose.theta()), 0.02);
  EXPECT_LT(found->num_scored, static_cast<int64_t>(Grid(world).size() / 5));
}

}  // namespace
}  // namespace arborslam
