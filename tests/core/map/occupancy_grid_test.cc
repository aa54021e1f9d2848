#include "core/map/occupancy_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

using CellIndex = std::pair<int, int>;  // Cell (x, y) of the plane covers [x, x + 1) by [y, y + 1) cell sizes.

constexpr float kEverything = -std::numeric_limits<float>::infinity();

// log(p / (1 - p)) of the probabilities that `WithCellSize` sets.
constexpr double kHit = 1.3862943611198906;     // log 4
constexpr double kMiss = -0.40546510810816444;  // log(2 / 3)
constexpr double kMin = -1.9924301646902063;    // log(12 / 88)
constexpr double kMax = 3.4760986898352733;     // log(97 / 3)

OccupancyGridOptions WithCellSize(double cell_size) {
  OccupancyGridOptions options;
  options.hit_probability = 0.8;
  options.miss_probability = 0.4;
  options.min_probability = 0.12;
  options.max_probability = 0.97;
  options.miss_range = 1000.0;
  options.cell_size = cell_size;
  return options;
}

CellIndex CellOf(const Eigen::Vector2d& position, double cell_size) {
  return {static_cast<int>(std::floor(position.x() / cell_size)),
          static_cast<int>(std::floor(position.y() / cell_size))};
}

// What a grid says about a cell of the plane, wherever its own array begins.
struct View {
  bool known = false;
  double log_odds = 0.0;
};

View At(const OccupancyGrid& grid, const CellIndex& cell) {
  const int x = cell.first - static_cast<int>(std::lround(grid.origin().x() / grid.cell_size()));
  const int y = cell.second - static_cast<int>(std::lround(grid.origin().y() / grid.cell_size()));
  if (x < 0 || y < 0 || x >= grid.width() || y >= grid.height()) return {};
  return {grid.IsKnown(x, y), grid.LogOdds(x, y)};
}

std::set<CellIndex> KnownCells(const OccupancyGrid& grid) {
  std::set<CellIndex> known;
  const auto first_x = static_cast<int>(std::lround(grid.origin().x() / grid.cell_size()));
  const auto first_y = static_cast<int>(std::lround(grid.origin().y() / grid.cell_size()));
  for (int x = 0; x < grid.width(); ++x) {
    for (int y = 0; y < grid.height(); ++y) {
      if (grid.IsKnown(x, y)) known.insert({first_x + x, first_y + y});
    }
  }
  return known;
}

PlanarScan ScanOf(const std::vector<Eigen::Vector2f>& points, const std::vector<Eigen::Vector2f>& free_ends = {}) {
  PlanarScan scan;
  scan.points = points;
  scan.free_ends = free_ends;
  return scan;
}

// The fraction of the way from `from` to `to` that lies in a cell (Liang and Barsky 1984): 0 when it meets a corner
// only, negative when it misses.
double FractionInside(const CellIndex& cell, double cell_size, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  double enter = 0.0;
  double leave = 1.0;
  const std::array<double, 2> low = {cell.first * cell_size, cell.second * cell_size};
  for (int axis = 0; axis < 2; ++axis) {
    const double corner = low[static_cast<size_t>(axis)];
    const double direction = to(axis) - from(axis);
    if (direction == 0.0) {
      if (from(axis) < corner || from(axis) >= corner + cell_size) return -1.0;
      continue;
    }
    double at_low = (corner - from(axis)) / direction;
    double at_high = (corner + cell_size - from(axis)) / direction;
    if (at_low > at_high) std::swap(at_low, at_high);
    enter = std::max(enter, at_low);
    leave = std::min(leave, at_high);
  }
  return leave - enter;
}

TEST(OccupancyGridOptionsTest, DefaultsAreValidAndViolationsAreNamed) {
  EXPECT_EQ(OccupancyGridOptions().Validate(), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<std::pair<const char*, double OccupancyGridOptions::*>, 5> fields = {
      {{"cell_size", &OccupancyGridOptions::cell_size},
       {"hit_probability", &OccupancyGridOptions::hit_probability},
       {"miss_probability", &OccupancyGridOptions::miss_probability},
       {"min_probability", &OccupancyGridOptions::min_probability},
       {"max_probability", &OccupancyGridOptions::max_probability}}};
  for (const auto& [name, field] : fields) {
    for (const double value : {-0.1, 0.0, 1.5, nan}) {
      OccupancyGridOptions options;
      options.*field = value;
      EXPECT_EQ(options.Validate().find(name), 0u) << name << " = " << value << ": \"" << options.Validate() << "\"";
    }
  }
  OccupancyGridOptions swapped;
  std::swap(swapped.hit_probability, swapped.miss_probability);
  EXPECT_NE(swapped.Validate(), "");
}

TEST(LogOddsTest, KnownValuesAndInverse) {
  EXPECT_EQ(LogOddsOf(0.5), 0.0);
  EXPECT_NEAR(LogOddsOf(0.8), kHit, 1e-12);
  EXPECT_NEAR(LogOddsOf(0.4), kMiss, 1e-12);
  EXPECT_NEAR(LogOddsOf(0.12), kMin, 1e-12);
  EXPECT_NEAR(LogOddsOf(0.97), kMax, 1e-12);
  for (double p = 0.01; p < 1.0; p += 0.01) EXPECT_NEAR(ProbabilityOf(LogOddsOf(p)), p, 1e-12);
}

TEST(OccupancyGridTest, RaysCountAsMissesNoFartherThanTheMissRange) {
  OccupancyGridOptions options = WithCellSize(0.1);
  options.miss_range = 2.0;
  OccupancyGrid grid(options);
  grid.Insert(SE2(0.05, 0.05, 0.0), ScanOf({{5.0f, 0.0f}}, {{0.0f, 5.0f}}));
  for (int i = 0; i < 49; ++i) {
    EXPECT_EQ(At(grid, {i, 0}).known, i < 20) << i;
    EXPECT_EQ(At(grid, {0, i}).known, i < 20) << i;
  }
  EXPECT_NEAR(At(grid, {50, 0}).log_odds, kHit, 1e-6) << "a hit counts at any range";

  options.miss_range = -1.0;
  EXPECT_EQ(options.Validate().find("miss_range"), 0u);
}

TEST(OccupancyGridTest, StartsEmpty) {
  const OccupancyGrid grid((OccupancyGridOptions()));
  EXPECT_EQ(grid.width(), 0);
  EXPECT_EQ(grid.height(), 0);
  EXPECT_EQ(grid.cell_size(), 0.05);
  EXPECT_TRUE(grid.OccupiedCells(kEverything).empty());
}

TEST(OccupancyGridTest, OneRayByHand) {
  OccupancyGrid grid(WithCellSize(1.0));
  grid.Insert(SE2(0.5, 0.5, 0.0), ScanOf({{4.0f, 0.0f}}));
  const std::set<CellIndex> passed = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
  for (const CellIndex& cell : passed) EXPECT_NEAR(At(grid, cell).log_odds, kMiss, 1e-6);
  EXPECT_NEAR(At(grid, {4, 0}).log_odds, kHit, 1e-6);
  std::set<CellIndex> known = passed;
  known.insert({4, 0});
  EXPECT_EQ(KnownCells(grid), known);
  const std::vector<OccupiedCell> occupied = grid.OccupiedCells(0.0f);
  ASSERT_EQ(occupied.size(), 1u);
  EXPECT_TRUE(occupied[0].centroid.isApprox(Eigen::Vector2f(4.5f, 0.5f)));
  EXPECT_NEAR(occupied[0].log_odds, kHit, 1e-6);
}

TEST(OccupancyGridTest, LogOddsAddUpAndAreClamped) {
  OccupancyGrid grid(WithCellSize(1.0));
  const PlanarScan scan = ScanOf({{3.0f, 0.0f}});
  for (int n = 1; n <= 30; ++n) {
    grid.Insert(SE2(0.5, 0.5, 0.0), scan);
    EXPECT_NEAR(At(grid, {3, 0}).log_odds, std::min(n * kHit, kMax), 1e-5) << n;
    EXPECT_NEAR(At(grid, {1, 0}).log_odds, std::max(n * kMiss, kMin), 1e-5) << n;
  }
  EXPECT_NEAR(ProbabilityOf(At(grid, {3, 0}).log_odds), 0.97, 1e-6);
  EXPECT_NEAR(ProbabilityOf(At(grid, {1, 0}).log_odds), 0.12, 1e-6);
  // A clamped cell can be lost, and a lost one won back.
  const PlanarScan beyond = ScanOf({{6.0f, 0.0f}});
  for (int n = 1; n <= 20; ++n) {
    grid.Insert(SE2(0.5, 0.5, 0.0), beyond);
    EXPECT_NEAR(At(grid, {3, 0}).log_odds, std::max(kMax + n * kMiss, kMin), 1e-5) << n;
  }
  for (int n = 1; n <= 10; ++n) {
    grid.Insert(SE2(0.5, 0.5, 0.0), scan);
    EXPECT_NEAR(At(grid, {3, 0}).log_odds, std::min(kMin + n * kHit, kMax), 1e-5) << n;
  }
}

TEST(OccupancyGridTest, AScanUpdatesACellOnce) {
  OccupancyGrid grid(WithCellSize(1.0));
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(4.0f, -0.4f + 0.02f * static_cast<float>(i));
  grid.Insert(SE2(0.5, 0.5, 0.0), ScanOf(points, points));
  EXPECT_NEAR(At(grid, {4, 0}).log_odds, kHit, 1e-6);
  EXPECT_NEAR(At(grid, {0, 0}).log_odds, kMiss, 1e-6);
  EXPECT_NEAR(At(grid, {2, 0}).log_odds, kMiss, 1e-6);
}

TEST(OccupancyGridTest, AHitWinsOverRaysOfTheSameScan) {
  const Eigen::Vector2f near(2.0f, 0.0f);
  const Eigen::Vector2f far(6.0f, 0.0f);
  for (const PlanarScan& scan : {ScanOf({near, far}), ScanOf({far, near}), ScanOf({near}, {far})}) {
    OccupancyGrid grid(WithCellSize(1.0));
    grid.Insert(SE2(0.5, 0.5, 0.0), scan);
    EXPECT_NEAR(At(grid, {2, 0}).log_odds, kHit, 1e-6);
    EXPECT_NEAR(At(grid, {1, 0}).log_odds, kMiss, 1e-6);
    EXPECT_NEAR(At(grid, {4, 0}).log_odds, kMiss, 1e-6);
  }
}

TEST(OccupancyGridTest, FreeEndsFreeTheirRaysAndHitNothing) {
  OccupancyGrid grid(WithCellSize(1.0));
  grid.Insert(SE2(0.5, 0.5, 0.5 * kPi), ScanOf({}, {{5.0f, 0.0f}}));
  EXPECT_EQ(KnownCells(grid), (std::set<CellIndex>{{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}}));
  EXPECT_NEAR(At(grid, {0, 4}).log_odds, kMiss, 1e-6);
  EXPECT_TRUE(grid.OccupiedCells(kEverything).empty());
}

TEST(OccupancyGridTest, PointAtTheRobotHitsItsCellOnly) {
  OccupancyGrid grid(WithCellSize(1.0));
  grid.Insert(SE2(-3.5, 2.5, 1.0), ScanOf({{0.0f, 0.0f}}));
  EXPECT_EQ(KnownCells(grid), (std::set<CellIndex>{{-4, 2}}));
  EXPECT_NEAR(At(grid, {-4, 2}).log_odds, kHit, 1e-6);
}

TEST(OccupancyGridTest, EmptyScansChangeNothing) {
  OccupancyGrid grid(WithCellSize(1.0));
  grid.Insert(SE2(3.0, 3.0, 0.0), PlanarScan());
  EXPECT_TRUE(KnownCells(grid).empty());
  EXPECT_TRUE(grid.OccupiedCells(kEverything).empty());
  grid.Insert(SE2(0.5, 0.5, 0.0), ScanOf({{4.0f, 0.0f}}));
  const std::set<CellIndex> known = KnownCells(grid);
  EXPECT_EQ(known.size(), 5u);
  grid.Insert(SE2(-500.0, 300.0, 0.0), PlanarScan());
  EXPECT_EQ(KnownCells(grid), known);
  EXPECT_NEAR(At(grid, {4, 0}).log_odds, kHit, 1e-6);
}

TEST(OccupancyGridTest, NegativeCoordinatesAreRoundedDown) {
  OccupancyGrid grid(WithCellSize(0.5));
  grid.Insert(SE2(-0.25, -0.25, 0.0), ScanOf({{-1.01f, -1.01f}, {0.24f, 0.24f}, {0.26f, 0.26f}}));
  EXPECT_NEAR(At(grid, {-3, -3}).log_odds, kHit, 1e-6);  // [-1.5, -1.0) holds -1.26.
  EXPECT_NEAR(At(grid, {-1, -1}).log_odds, kHit, 1e-6);  // [-0.5, 0) holds -0.01.
  EXPECT_NEAR(At(grid, {0, 0}).log_odds, kHit, 1e-6);    // [0, 0.5) holds 0.01.
}

TEST(OccupancyGridTest, GrowthKeepsItsContent) {
  OccupancyGrid grid(WithCellSize(0.5));
  Random random(1);
  std::map<CellIndex, View> before;
  const std::vector<SE2> poses = {SE2(0.0, 0.0, 0.3),     SE2(130.0, 0.0, 1.0),   SE2(-170.0, 0.2, 2.0),
                                  SE2(0.0, 210.0, -1.0),  SE2(0.0, -190.0, -3.0), SE2(-200.0, 300.0, 0.0),
                                  SE2(200.0, -300.0, 0.0)};
  for (const SE2& pose : poses) {
    PlanarScan scan;
    for (int i = 0; i < 30; ++i) {
      const auto x = static_cast<float>(random.Uniform(-8.0, 8.0));
      scan.points.emplace_back(x, static_cast<float>(random.Uniform(-8.0, 8.0)));
    }
    const int width = grid.width();
    const int height = grid.height();
    grid.Insert(pose, scan);
    EXPECT_TRUE(grid.width() > width || grid.height() > height);
    for (const auto& [cell, view] : before) {
      ASSERT_TRUE(At(grid, cell).known) << cell.first << ", " << cell.second;
      ASSERT_EQ(At(grid, cell).log_odds, view.log_odds) << cell.first << ", " << cell.second;
    }
    const std::set<CellIndex> known = KnownCells(grid);
    EXPECT_GT(known.size(), before.size() + 30);
    for (const CellIndex& cell : known) before[cell] = At(grid, cell);
  }
  EXPECT_GT(grid.OccupiedCells(0.0f).size(), 200u);
  for (const OccupiedCell& cell : grid.OccupiedCells(kEverything)) {
    EXPECT_EQ(At(grid, CellOf(cell.centroid.cast<double>(), 0.5)).log_odds, cell.log_odds);
  }
}

TEST(OccupancyGridTest, ScansThatEndAtTheGridsEdges) {
  for (const double nudge : {-1e-9, 0.0, 1e-9, -0.24, 0.24, -0.5, 0.5, -1.0, 1.0}) {
    for (int side = 0; side < 4; ++side) {
      OccupancyGrid grid(WithCellSize(0.5));
      const SE2 robot(1.1, -2.3, 0.0);
      grid.Insert(robot, ScanOf({{1.0f, 0.0f}}));
      const Eigen::Vector2d low = grid.origin();
      const Eigen::Vector2d high = low + 0.5 * Eigen::Vector2d(grid.width(), grid.height());
      Eigen::Vector2d target(0.8, -1.7);
      (side % 2 == 0 ? target.x() : target.y()) = nudge + (side == 0   ? low.x()
                                                           : side == 1 ? low.y()
                                                           : side == 2 ? high.x()
                                                                       : high.y());
      // Both along a ray and as the robot's own place; the point's own rounding to float is part of its place.
      const Eigen::Vector2f point = (target - robot.translation()).cast<float>();
      const Eigen::Vector2d hit = robot * point.cast<double>();
      grid.Insert(robot, ScanOf({point}, {1.01f * point}));
      grid.Insert(SE2(hit.x(), hit.y(), 0.0), ScanOf({{0.0f, 0.0f}, {-0.7f, 0.6f}}));
      EXPECT_NEAR(At(grid, CellOf(hit, 0.5)).log_odds, 2.0 * kHit, 1e-5) << "side " << side << ", nudge " << nudge;
    }
  }
}

TEST(OccupancyGridTest, RaysAlongCellBordersAndThroughCorners) {
  // Eight directions from a cell's corner and from its centre, by whole cells, so that every step is a tie.
  for (const double start : {0.0, 0.5, -3.0}) {
    for (int direction = 0; direction < 9; ++direction) {
      const Eigen::Vector2d reach(6.0 * (direction % 3 - 1), 6.0 * (direction / 3 - 1));
      const Eigen::Vector2d from(start, start);
      const Eigen::Vector2d to = from + reach;
      OccupancyGrid grid(WithCellSize(1.0));
      grid.Insert(SE2(start, start, 0.0), ScanOf({reach.cast<float>()}));
      SCOPED_TRACE("direction " + std::to_string(direction) + " from " + std::to_string(start));
      for (int x = -12; x <= 12; ++x) {
        for (int y = -12; y <= 12; ++y) {
          const CellIndex cell(x, y);
          const bool is_end = cell == CellOf(to, 1.0);
          const double inside = FractionInside(cell, 1.0, from, to);
          // Which of the cells that are met at a corner only are counted is left open.
          if (inside > 1e-9) {
            EXPECT_TRUE(At(grid, cell).known) << x << ", " << y;
          }
          if (At(grid, cell).known) {
            EXPECT_TRUE(is_end || inside > -1e-9) << x << ", " << y;
            EXPECT_NEAR(At(grid, cell).log_odds, is_end ? kHit : kMiss, 1e-6) << x << ", " << y;
          }
        }
      }
    }
  }
}

TEST(OccupancyGridTest, CentroidIsTheMeanOfAllHits) {
  OccupancyGrid grid(WithCellSize(0.05));
  const CellIndex cell(-201, 333);
  Random random(2);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int scan_index = 0; scan_index < 12; ++scan_index) {
    const SE2 pose(random.Uniform(-12.0, -8.0), random.Uniform(14.0, 18.0), random.Uniform(-kPi, kPi));
    PlanarScan scan;
    // Points that hit the cell several times in one scan all count.
    for (int i = 0; i <= scan_index % 3; ++i) {
      const double x = (cell.first + random.Uniform(0.05, 0.95)) * 0.05;
      const Eigen::Vector2d hit(x, (cell.second + random.Uniform(0.05, 0.95)) * 0.05);
      scan.points.push_back((pose.Inverse() * hit).cast<float>());
      sum += pose * scan.points.back().cast<double>();
      ++count;
    }
    grid.Insert(pose, scan);
  }
  const std::vector<OccupiedCell> occupied = grid.OccupiedCells(kEverything);
  ASSERT_EQ(occupied.size(), 1u);
  EXPECT_NEAR(occupied[0].centroid.x(), sum.x() / count, 2e-6);
  EXPECT_NEAR(occupied[0].centroid.y(), sum.y() / count, 2e-6);
  EXPECT_NEAR(occupied[0].log_odds, kMax, 1e-6);
}

TEST(OccupancyGridTest, OccupiedCellsByThresholdInOrderOfFirstHits) {
  OccupancyGrid grid(WithCellSize(1.0));
  const SE2 pose(0.5, 0.5, 0.0);
  grid.Insert(pose, ScanOf({{0.0f, 3.0f}, {5.0f, 0.0f}, {-2.0f, 0.0f}}));
  grid.Insert(pose, ScanOf({{-2.0f, 0.0f}, {0.0f, -4.0f}}));
  grid.Insert(pose, ScanOf({}, {{9.0f, 0.0f}}));
  const auto centroids = [&](float threshold) {
    std::vector<CellIndex> cells;
    for (const OccupiedCell& cell : grid.OccupiedCells(threshold)) {
      cells.push_back(CellOf(cell.centroid.cast<double>(), 1.0));
    }
    return cells;
  };
  const std::vector<CellIndex> all = {{0, 3}, {5, 0}, {-2, 0}, {0, -4}};
  EXPECT_EQ(centroids(kEverything), all);
  EXPECT_EQ(centroids(0.0f), all);
  EXPECT_EQ(centroids(static_cast<float>(kHit - 0.1)), (std::vector<CellIndex>{{0, 3}, {-2, 0}, {0, -4}}));
  EXPECT_EQ(centroids(static_cast<float>(kHit + 0.1)), (std::vector<CellIndex>{{-2, 0}}));
  EXPECT_TRUE(centroids(static_cast<float>(2.0 * kHit + 0.1)).empty());
  // "At least": a cell's own log-odds do not exclude it.
  const auto own = static_cast<float>(At(grid, {-2, 0}).log_odds);
  EXPECT_EQ(centroids(own), (std::vector<CellIndex>{{-2, 0}}));
}

// The same grid by definition: every cell of a ray's bounding box is tested for whether the ray runs through it.
class BruteForceGrid {
 public:
  struct Cell {
    double log_odds = 0.0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int hits = 0;
  };

  explicit BruteForceGrid(double cell_size) : cell_size_(cell_size) {}

  // False, and nothing done, when a ray comes too close to a corner for rounding not to matter.
  bool Insert(const SE2& pose, const PlanarScan& scan) {
    std::set<CellIndex> hit;
    std::set<CellIndex> passed;
    std::vector<Eigen::Vector2d> hits;
    for (const Eigen::Vector2f& point : scan.points) hits.push_back(pose * point.cast<double>());
    for (const Eigen::Vector2d& end : hits) {
      if (!Cast(pose.translation(), end, &passed)) return false;
    }
    for (const Eigen::Vector2f& end : scan.free_ends) {
      if (!Cast(pose.translation(), pose * end.cast<double>(), &passed)) return false;
    }
    for (const Eigen::Vector2d& end : hits) {
      const CellIndex index = CellOf(end, cell_size_);
      if (hit.insert(index).second && cells_[index].hits == 0) first_hits_.push_back(index);
      cells_[index].sum += end;
      ++cells_[index].hits;
    }
    for (const CellIndex& index : hit) cells_[index].log_odds = std::min(cells_[index].log_odds + kHit, kMax);
    for (const CellIndex& index : passed) {
      if (hit.count(index) == 0) cells_[index].log_odds = std::max(cells_[index].log_odds + kMiss, kMin);
    }
    return true;
  }

  const std::map<CellIndex, Cell>& cells() const { return cells_; }
  const std::vector<CellIndex>& first_hits() const { return first_hits_; }

 private:
  bool Cast(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::set<CellIndex>* passed) const {
    const CellIndex first = CellOf(from, cell_size_);
    const CellIndex last = CellOf(to, cell_size_);
    for (int x = std::min(first.first, last.first); x <= std::max(first.first, last.first); ++x) {
      for (int y = std::min(first.second, last.second); y <= std::max(first.second, last.second); ++y) {
        if (CellIndex{x, y} == last) continue;
        const double inside = FractionInside({x, y}, cell_size_, from, to);
        if (std::abs(inside) < 1e-9 && from != to) return false;
        if (inside > 0.0) passed->insert({x, y});
      }
    }
    return true;
  }

  double cell_size_;
  std::map<CellIndex, Cell> cells_;
  std::vector<CellIndex> first_hits_;
};

TEST(OccupancyGridTest, RandomScansAgreeWithBruteForce) {
  Random random(3);
  for (const double cell_size : {0.05, 0.2, 1.0}) {
    SCOPED_TRACE("cell size " + std::to_string(cell_size));
    OccupancyGrid grid(WithCellSize(cell_size));
    BruteForceGrid oracle(cell_size);
    int inserted = 0;
    for (int i = 0; i < 25; ++i) {
      const double reach = 15.0 * cell_size;
      const SE2 pose(random.Uniform(-reach, reach), random.Uniform(-reach, reach), random.Uniform(-kPi, kPi));
      PlanarScan scan;
      const int count = static_cast<int>(random.Uniform(0.0, 40.0));
      for (int j = 0; j < count; ++j) {
        const double x = random.Uniform(-reach, reach);
        const double y = random.Uniform(-reach, reach) * (j % 5 == 0 ? 0.01 : 1.0);
        auto& ends = j % 3 == 0 ? scan.free_ends : scan.points;
        ends.emplace_back(static_cast<float>(x), static_cast<float>(y));
      }
      if (!oracle.Insert(pose, scan)) continue;
      grid.Insert(pose, scan);
      ++inserted;
    }
    ASSERT_GE(inserted, 20);

    std::set<CellIndex> known;
    for (const auto& [index, cell] : oracle.cells()) known.insert(index);
    EXPECT_EQ(KnownCells(grid), known);
    for (const auto& [index, cell] : oracle.cells()) {
      EXPECT_NEAR(At(grid, index).log_odds, cell.log_odds, 1e-5) << index.first << ", " << index.second;
    }
    const std::vector<OccupiedCell> occupied = grid.OccupiedCells(kEverything);
    ASSERT_EQ(occupied.size(), oracle.first_hits().size());
    for (size_t i = 0; i < occupied.size(); ++i) {
      const BruteForceGrid::Cell& cell = oracle.cells().at(oracle.first_hits()[i]);
      EXPECT_LT((occupied[i].centroid.cast<double>() - cell.sum / cell.hits).norm(), 1e-5 * cell_size + 2e-6);
      EXPECT_NEAR(occupied[i].log_odds, cell.log_odds, 1e-5);
    }
  }
}

}  // namespace
}  // namespace arborslam
