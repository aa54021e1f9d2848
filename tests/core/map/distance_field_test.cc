#include "core/map/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

using CellIndex = std::pair<int, int>;

struct FieldOptions {
  double cell_size = 0.05;    // [m]
  double max_distance = 0.2;  // [m]
  DistanceMetric metric = DistanceMetric::kL2;
};

// A point of the cell, `across` and `along` [cells] off its centre.
Eigen::Vector2f PointIn(const CellIndex& cell, double cell_size, double across = 0.0, double along = 0.0) {
  return Eigen::Vector2d((cell.first + 0.5 + across) * cell_size, (cell.second + 0.5 + along) * cell_size)
      .cast<float>();
}

double CellsApart(const CellIndex& a, const CellIndex& b, DistanceMetric metric) {
  const double dx = a.first - b.first;
  const double dy = a.second - b.second;
  return metric == DistanceMetric::kL1 ? std::abs(dx) + std::abs(dy) : std::hypot(dx, dy);
}

// The definition, cell by cell: checks everything that a field of points in `cells` (the same cell may come more than
// once) says about the plane, `margin` cells beyond the field's own array included.
void CompareWithBruteForce(const std::vector<CellIndex>& cells, const std::vector<Eigen::Vector2f>& points,
                           const FieldOptions& options, int margin = 3) {
  const DistanceField field(points, options.cell_size, options.max_distance, options.metric);
  std::map<CellIndex, int> first_in_cell;
  for (size_t i = 0; i < cells.size(); ++i) first_in_cell.emplace(cells[i], static_cast<int>(i));
  const auto max_distance = static_cast<float>(options.max_distance);

  const std::vector<uint8_t> quantised = field.Quantised(63);
  ASSERT_EQ(quantised.size(), static_cast<size_t>(field.width()) * static_cast<size_t>(field.height()));
  for (int x = -margin; x < field.width() + margin; ++x) {
    for (int y = -margin; y < field.height() + margin; ++y) {
      const CellIndex here{field.first_x() + x, field.first_y() + y};
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& [cell, index] : first_in_cell) {
        nearest = std::min(nearest, CellsApart(here, cell, options.metric));
      }
      const bool reached = nearest * options.cell_size <= options.max_distance + 1e-6 * options.cell_size;
      const float expected =
          reached ? std::min(static_cast<float>(nearest * options.cell_size), max_distance) : max_distance;
      const std::string where = "cell " + std::to_string(here.first) + ", " + std::to_string(here.second);

      const Eigen::Vector2f point = PointIn(here, options.cell_size, 0.3, -0.3);
      ASSERT_FLOAT_EQ(field.Distance(point), expected) << where;
      const int index = field.Nearest(point);
      ASSERT_EQ(index >= 0, reached) << where << ", nearest occupied cell is " << nearest << " cells away";
      if (reached) {
        ASSERT_LT(index, static_cast<int>(cells.size()));
        const CellIndex& found = cells[static_cast<size_t>(index)];
        ASSERT_DOUBLE_EQ(CellsApart(here, found, options.metric), nearest) << where;
        ASSERT_EQ(index, first_in_cell.at(found)) << where;
      }
      if (x < 0 || y < 0 || x >= field.width() || y >= field.height()) continue;
      ASSERT_EQ(field.NearestAt(x, y), index) << where;
      ASSERT_EQ(field.DistanceAt(x, y), field.Distance(point)) << where;
      const int quantum = quantised[static_cast<size_t>(x * field.height() + y)];
      ASSERT_LE(quantum, 63) << where;
      if (options.max_distance > 0.0) {
        ASSERT_LE(quantum, 63.0 * expected / max_distance + 1e-4) << where;
        ASSERT_GT(quantum + 1, 63.0 * expected / max_distance - 1e-4) << where;
      }
    }
  }
}

void CompareWithBruteForce(const std::vector<CellIndex>& cells, const FieldOptions& options) {
  std::vector<Eigen::Vector2f> points;
  for (const CellIndex& cell : cells) points.push_back(PointIn(cell, options.cell_size));
  CompareWithBruteForce(cells, points, options);
}

constexpr DistanceMetric kMetrics[] = {DistanceMetric::kL1, DistanceMetric::kL2};

TEST(DistanceFieldTest, DefaultAndEmptyAreFarFromEverything) {
  const DistanceField none;
  EXPECT_EQ(none.Nearest({0.0f, 0.0f}), -1);
  EXPECT_EQ(none.Distance({0.0f, 0.0f}), none.max_distance());
  for (const DistanceMetric metric : kMetrics) {
    const DistanceField empty({}, 0.05, 0.2, metric);
    for (const Eigen::Vector2f& point : {Eigen::Vector2f(0.0f, 0.0f), Eigen::Vector2f(-3.0f, 7.0f)}) {
      EXPECT_EQ(empty.Nearest(point), -1);
      EXPECT_FLOAT_EQ(empty.Distance(point), 0.2f);
    }
    EXPECT_EQ(empty.width(), 0);
    EXPECT_EQ(empty.height(), 0);
    EXPECT_TRUE(empty.Quantised(63).empty());
  }
}

TEST(DistanceFieldTest, SingleCellByHand) {
  const DistanceField field({{0.12f, -0.03f}}, 0.1, 0.3, DistanceMetric::kL2);
  EXPECT_EQ(field.cell_size(), 0.1f);
  EXPECT_EQ(field.max_distance(), 0.3f);
  // The cell (1, -1) and three cells all around.
  EXPECT_EQ(field.first_x(), -2);
  EXPECT_EQ(field.first_y(), -4);
  EXPECT_EQ(field.width(), 7);
  EXPECT_EQ(field.height(), 7);
  EXPECT_EQ(field.Distance({0.19f, -0.09f}), 0.0f);
  EXPECT_FLOAT_EQ(field.Distance({0.21f, -0.05f}), 0.1f);
  EXPECT_FLOAT_EQ(field.Distance({0.05f, 0.05f}), std::sqrt(0.02f));
  EXPECT_FLOAT_EQ(field.Distance({0.15f, 0.25f}), 0.3f);
  EXPECT_EQ(field.Nearest({0.15f, 0.25f}), 0);  // Just within reach.
  EXPECT_FLOAT_EQ(field.Distance({0.25f, 0.25f}), 0.3f);
  EXPECT_EQ(field.Nearest({0.25f, 0.25f}), -1);  // Just beyond it.
  const DistanceField l1({{0.12f, -0.03f}}, 0.1, 0.3, DistanceMetric::kL1);
  EXPECT_FLOAT_EQ(l1.Distance({0.05f, 0.05f}), 0.2f);
  EXPECT_EQ(l1.Nearest({0.35f, 0.05f}), 0);
  EXPECT_EQ(l1.Nearest({0.35f, 0.15f}), -1);
}

TEST(DistanceFieldTest, RandomSetsOfEveryDensity) {
  Random random(1);
  for (const DistanceMetric metric : kMetrics) {
    for (const double density : {0.002, 0.01, 0.03, 0.1, 0.3, 0.7, 0.95}) {
      for (int trial = 0; trial < 4; ++trial) {
        const int width = 1 + static_cast<int>(random.Uniform(0.0, 25.0));
        const int height = 1 + static_cast<int>(random.Uniform(0.0, 25.0));
        const int first_x = static_cast<int>(random.Uniform(-40.0, 20.0));
        const int first_y = static_cast<int>(random.Uniform(-40.0, 20.0));
        std::vector<CellIndex> cells;
        for (int x = 0; x < width; ++x) {
          for (int y = 0; y < height; ++y) {
            if (random.Uniform() < density) cells.push_back({first_x + x, first_y + y});
          }
        }
        // The order of the points must not matter.
        for (size_t i = cells.size(); i > 1; --i) {
          std::swap(cells[i - 1], cells[static_cast<size_t>(random.Uniform() * static_cast<double>(i))]);
        }
        const double reach = std::floor(random.Uniform(0.0, 9.0));
        SCOPED_TRACE("density " + std::to_string(density) + ", trial " + std::to_string(trial) + ", reach " +
                     std::to_string(reach));
        ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(cells, {0.05, 0.05 * reach, metric}));
      }
    }
  }
}

TEST(DistanceFieldTest, ReachThatIsNoWholeNumberOfCells) {
  // 2.5 cells hold the cell (2, 1), which is 2.24 away, though neither a cell at 3 nor one at (2, 2).
  Random random(2);
  for (const DistanceMetric metric : kMetrics) {
    for (const double reach : {0.4, 0.999, 1.42, 2.5, 3.33, 4.6, 7.3}) {
      std::vector<CellIndex> cells;
      for (int i = 0; i < 12; ++i) {
        const int x = static_cast<int>(random.Uniform(-15.0, 15.0));
        cells.push_back({x, static_cast<int>(random.Uniform(-15.0, 15.0))});
      }
      SCOPED_TRACE("reach " + std::to_string(reach));
      ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(cells, {0.05, 0.05 * reach, metric}));
    }
  }
}

TEST(DistanceFieldTest, CellSizesOtherThanTheDefault) {
  const std::vector<CellIndex> cells = {{-7, 3}, {0, 0}, {1, 0}, {5, -6}, {5, 8}};
  for (const DistanceMetric metric : kMetrics) {
    for (const double cell_size : {0.01, 0.1, 0.25, 1.0}) {
      SCOPED_TRACE("cell size " + std::to_string(cell_size));
      ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(cells, {cell_size, 6.0 * cell_size, metric}));
    }
  }
}

TEST(DistanceFieldTest, FullBlock) {
  std::vector<CellIndex> cells;
  for (int x = -6; x < 6; ++x) {
    for (int y = 2; y < 15; ++y) cells.push_back({x, y});
  }
  for (const DistanceMetric metric : kMetrics) {
    ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(cells, {0.05, 0.25, metric}));
  }
}

TEST(DistanceFieldTest, RowsColumnsDiagonalsAndFrames) {
  std::vector<CellIndex> row;
  std::vector<CellIndex> column;
  std::vector<CellIndex> diagonal;
  std::vector<CellIndex> frame;
  for (int i = -10; i <= 10; ++i) {
    row.push_back({i, 4});
    column.push_back({-3, i});
    diagonal.push_back({i, -i});
    frame.insert(frame.end(), {{i, -10}, {i, 10}, {-10, i}, {10, i}});
  }
  for (const DistanceMetric metric : kMetrics) {
    for (const auto& cells : {row, column, diagonal, frame}) {
      ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(cells, {0.05, 0.3, metric}));
    }
  }
}

TEST(DistanceFieldTest, EquidistantCells) {
  for (const DistanceMetric metric : kMetrics) {
    for (int x = -6; x <= 6; ++x) {
      for (int y = -6; y <= 6; ++y) {
        ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce({{-x, -y}, {x, y}}, {0.05, 0.35, metric}));
        ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce({{x, y}, {y, x}, {-x, y}}, {0.05, 0.35, metric}));
      }
    }
  }
}

TEST(DistanceFieldTest, FirstPointOfACellCounts) {
  // Several points in each of a few cells, the same cells over and over.
  const std::vector<CellIndex> distinct = {{0, 0}, {-1, 0}, {4, -3}, {4, 5}};
  std::vector<CellIndex> cells;
  std::vector<Eigen::Vector2f> points;
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    const CellIndex& cell = distinct[static_cast<size_t>(random.Uniform() * 4.0)];
    const double across = random.Uniform(-0.45, 0.45);
    cells.push_back(cell);
    points.push_back(PointIn(cell, 0.05, across, random.Uniform(-0.45, 0.45)));
  }
  for (const DistanceMetric metric : kMetrics) {
    ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(cells, points, {0.05, 0.3, metric}));
  }
}

TEST(DistanceFieldTest, WithoutReachOnlyTheCellsThemselvesAreFound) {
  for (const DistanceMetric metric : kMetrics) {
    const DistanceField field({{0.12f, 0.12f}, {-0.12f, 0.12f}}, 0.05, 0.0, metric);
    EXPECT_EQ(field.Nearest({0.14f, 0.11f}), 0);
    EXPECT_EQ(field.Nearest({-0.14f, 0.11f}), 1);
    EXPECT_EQ(field.Nearest({0.16f, 0.11f}), -1);
    EXPECT_EQ(field.Distance({0.16f, 0.11f}), 0.0f);
  }
}

TEST(DistanceFieldTest, TheLongestReach) {
  for (const DistanceMetric metric : kMetrics) {
    const DistanceField field({{0.5f, 0.5f}, {20.5f, 0.5f}}, 1.0, 150.0, metric);
    EXPECT_EQ(field.Nearest({-149.5f, 0.5f}), 0);
    EXPECT_FLOAT_EQ(field.Distance({-149.5f, 0.5f}), 150.0f);
    EXPECT_EQ(field.Nearest({-150.5f, 0.5f}), -1);
    EXPECT_EQ(field.Nearest({20.5f, 150.5f}), 1);
    EXPECT_FLOAT_EQ(field.Distance({20.5f, -148.5f}), 149.0f);
  }
  EXPECT_DEATH(DistanceField({}, 1.0, 152.0, DistanceMetric::kL2), "too many cells");
}

TEST(DistanceFieldTest, PointsFarApart) {
  // 3 km of road across and along, at 5 cm.
  for (const DistanceMetric metric : kMetrics) {
    for (const bool along : {false, true}) {
      const auto at = [along](float distance, float aside) {
        return along ? Eigen::Vector2f(aside, distance) : Eigen::Vector2f(distance, aside);
      };
      const std::vector<Eigen::Vector2f> points = {at(-1500.02f, 0.02f), at(0.02f, 0.12f), at(2000.02f, 0.02f)};
      const DistanceField field(points, 0.05, 0.2, metric);
      for (size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(field.Nearest(points[i]), static_cast<int>(i));
        EXPECT_EQ(field.Nearest(points[i] + at(0.15f, 0.0f)), static_cast<int>(i));
        EXPECT_EQ(field.Nearest(points[i] - at(0.15f, 0.0f)), static_cast<int>(i));
        EXPECT_FLOAT_EQ(field.Distance(points[i] + at(0.15f, 0.0f)), 0.15f);
        EXPECT_EQ(field.Nearest(points[i] + at(1.0f, 0.0f)), -1);
      }
    }
  }
}

TEST(DistanceFieldTest, QuantisedRoundsDown) {
  // Distances of 0, 1, 2, 3 and 4 of 4 cells in 6 steps: 0, 1.5, 3, 4.5, 6.
  const DistanceField field({{0.5f, 0.5f}}, 1.0, 4.0, DistanceMetric::kL1);
  const std::vector<uint8_t> quantised = field.Quantised(6);
  const auto at = [&](int x, int y) {
    return static_cast<int>(
        quantised[static_cast<size_t>((x - field.first_x()) * field.height() + y - field.first_y())]);
  };
  EXPECT_EQ(at(0, 0), 0);
  EXPECT_EQ(at(1, 0), 1);
  EXPECT_EQ(at(-1, 1), 3);
  EXPECT_EQ(at(0, -3), 4);
  EXPECT_EQ(at(0, 4), 6);
  EXPECT_EQ(at(4, 4), 6);
  const std::vector<uint8_t> fine = field.Quantised(255);
  EXPECT_EQ(*std::max_element(fine.begin(), fine.end()), 255);
  EXPECT_EQ(std::count(fine.begin(), fine.end(), 0), 1);
}

}  // namespace
}  // namespace arborslam
