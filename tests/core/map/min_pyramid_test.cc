#include "core/map/min_pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

// The definition: the least quantised distance in the window of 2^level by 2^level cells that starts at (x, y).
int LeastInWindow(const DistanceField& field, const std::vector<uint8_t>& quantised, int level, int x, int y) {
  int least = MinPyramid::kNumSteps;
  for (int column = std::max(x, 0); column < std::min(x + (1 << level), field.width()); ++column) {
    for (int row = std::max(y, 0); row < std::min(y + (1 << level), field.height()); ++row) {
      least = std::min<int>(least, quantised[static_cast<size_t>(column * field.height() + row)]);
    }
  }
  return least;
}

// Every window that touches the field, and some that do not, of a pyramid made in two steps.
void CompareWithBruteForce(const DistanceField& field, int num_levels) {
  MinPyramid pyramid(field, (num_levels + 1) / 2);
  pyramid.Extend(num_levels);
  pyramid.Extend(1);
  const std::vector<uint8_t> quantised = field.Quantised(MinPyramid::kNumSteps);
  ASSERT_EQ(pyramid.num_levels(), num_levels);
  for (int level = 0; level < num_levels; ++level) {
    const int beyond = (1 << level) + 3;
    for (int x = -beyond; x < field.width() + 3; ++x) {
      for (int y = -beyond; y < field.height() + 3; ++y) {
        ASSERT_EQ(pyramid.level(level).At(x, y), LeastInWindow(field, quantised, level, x, y))
            << "level " << level << ", window at " << x << ", " << y;
      }
    }
  }
}

std::vector<Eigen::Vector2f> RandomPoints(int count, float width, float height, Random* random) {
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < count; ++i) {
    const auto x = static_cast<float>(random->Uniform(-0.5, 0.5)) * width;
    points.emplace_back(x, static_cast<float>(random->Uniform(-0.5, 0.5)) * height);
  }
  return points;
}

TEST(MinPyramidTest, EveryWindowOfRandomFields) {
  Random random(1);
  for (const DistanceMetric metric : {DistanceMetric::kL1, DistanceMetric::kL2}) {
    for (const int count : {1, 2, 5, 20, 100}) {
      const DistanceField field(RandomPoints(count, 1.5f, 1.0f, &random), 0.05, 0.2, metric);
      SCOPED_TRACE(std::to_string(count) + " points");
      ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(field, 5));
    }
  }
}

TEST(MinPyramidTest, WindowsMuchWiderThanTheField) {
  Random random(2);
  const DistanceField point({{0.02f, 0.02f}}, 0.05, 0.0, DistanceMetric::kL2);
  ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(point, 6));
  const DistanceField row(RandomPoints(5, 1.0f, 0.0f, &random), 0.05, 0.1, DistanceMetric::kL2);
  ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(row, 7));
  const DistanceField column(RandomPoints(5, 0.0f, 1.0f, &random), 0.05, 0.1, DistanceMetric::kL2);
  ASSERT_NO_FATAL_FAILURE(CompareWithBruteForce(column, 7));
}

TEST(MinPyramidTest, SingleCellByHand) {
  // One occupied cell in the middle of a field of 3 by 3, the others one cell away or out of reach.
  const DistanceField field({{0.5f, 0.5f}}, 1.0, 1.0, DistanceMetric::kL1);
  const MinPyramid pyramid(field, 2);
  const MinPyramid::Level& cells = pyramid.level(0);
  EXPECT_EQ(cells.At(1, 1), 0);
  EXPECT_EQ(cells.At(0, 1), MinPyramid::kNumSteps);
  EXPECT_EQ(cells.At(-1, 1), MinPyramid::kNumSteps);
  const MinPyramid::Level& pairs = pyramid.level(1);
  for (int x = -2; x <= 3; ++x) {
    for (int y = -2; y <= 3; ++y) {
      const bool covers = (x == 0 || x == 1) && (y == 0 || y == 1);
      EXPECT_EQ(pairs.At(x, y), covers ? 0 : MinPyramid::kNumSteps) << x << ", " << y;
    }
  }
}

// What is free in a random fan of rays.
FreeArea RandomFreeArea(double cell_size, Random* random) {
  OccupancyGridOptions options;
  options.cell_size = cell_size;
  OccupancyGrid grid(options);
  PlanarScan scan;
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.04 * i;
    const double range = random->Uniform(0.4, 1.5);
    scan.free_ends.emplace_back(range * std::cos(angle), range * std::sin(angle));
  }
  grid.Insert(SE2(random->Uniform(-1.0, 1.0), random->Uniform(-1.0, 1.0), random->Uniform(-3.0, 3.0)), scan);
  return FreeArea(grid);
}

TEST(MinPyramidTest, TellsWhichWindowsWereSeen) {
  Random random(4);
  int num_of_each[4] = {0, 0, 0, 0};  // Near or far, seen or not.
  for (int trial = 0; trial < 5; ++trial) {
    const DistanceField field(RandomPoints(5, 1.5f, 1.0f, &random), 0.05, 0.2, DistanceMetric::kL2);
    const FreeArea free_area = RandomFreeArea(0.1, &random);
    MinPyramid pyramid(field, free_area, 2);
    pyramid.Extend(5);
    const MinPyramid::Level& cells = pyramid.level(0);
    const MinPyramid plain(field, 1);
    const int shift_x = pyramid.first_x() - field.first_x();
    const int shift_y = pyramid.first_y() - field.first_y();
    for (int x = -5; x < cells.width + 5; ++x) {
      for (int y = -5; y < cells.height + 5; ++y) {
        const int distance = plain.level(0).At(x + shift_x, y + shift_y);
        const Eigen::Vector2f center(static_cast<float>(pyramid.first_x() + x) + 0.5f,
                                     static_cast<float>(pyramid.first_y() + y) + 0.5f);
        const bool is_inside = x >= 0 && y >= 0 && x < cells.width && y < cells.height;
        const bool is_seen =
            distance < MinPyramid::kNumSteps || (is_inside && free_area.Contains(field.cell_size() * center));
        ASSERT_EQ(cells.At(x, y), distance + (is_seen ? 0 : MinPyramid::kUnseen)) << x << ", " << y;
      }
    }
    for (int level = 1; level < 5; ++level) {
      const int size = 1 << level;
      for (int x = -size - 3; x < cells.width + 3; ++x) {
        for (int y = -size - 3; y < cells.height + 3; ++y) {
          int least = MinPyramid::kNumSteps;
          int unseen = 0;
          for (int column = x; column < x + size; ++column) {
            for (int row = y; row < y + size; ++row) {
              least = std::min(least, cells.At(column, row) & MinPyramid::kNumSteps);
              unseen |= cells.At(column, row) & MinPyramid::kUnseen;
            }
          }
          ASSERT_EQ(pyramid.level(level).At(x, y), least + unseen) << "level " << level << " at " << x << ", " << y;
          ++num_of_each[(least < MinPyramid::kNumSteps ? 0 : 2) + (unseen != 0 ? 1 : 0)];
        }
      }
    }
  }
  for (const int count : num_of_each) EXPECT_GT(count, 100);
}

TEST(MinPyramidTest, EmptyFieldIsTooFarEverywhere) {
  const MinPyramid pyramid(DistanceField({}, 0.05, 0.2, DistanceMetric::kL2), 4);
  for (int level = 0; level < 4; ++level) {
    for (int x = -9; x <= 9; ++x) {
      for (int y = -9; y <= 9; ++y) EXPECT_EQ(pyramid.level(level).At(x, y), MinPyramid::kNumSteps);
    }
  }
}

TEST(MinPyramidTest, BoundsEveryDistanceOfItsWindowInMetres) {
  Random random(3);
  const DistanceField field(RandomPoints(15, 2.0f, 2.0f, &random), 0.05, 0.3, DistanceMetric::kL2);
  const MinPyramid pyramid(field, 4);
  EXPECT_FLOAT_EQ(pyramid.metres_per_step() * MinPyramid::kNumSteps, 0.3f);
  for (int trial = 0; trial < 20000; ++trial) {
    const int level = static_cast<int>(random.Uniform(0.0, 4.0));
    const int x = static_cast<int>(random.Uniform(0.0, field.width()));
    const int y = static_cast<int>(random.Uniform(0.0, field.height()));
    const int window_x = x - static_cast<int>(random.Uniform(0.0, 1 << level));
    const int window_y = y - static_cast<int>(random.Uniform(0.0, 1 << level));
    const float bound = static_cast<float>(pyramid.level(level).At(window_x, window_y)) * pyramid.metres_per_step();
    ASSERT_LE(bound, field.DistanceAt(x, y) + 1e-6f);
  }
}

}  // namespace
}  // namespace arborslam
