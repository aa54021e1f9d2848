#include "core/evaluation/map_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr uint8_t kUnknown = GridImage::kUnknown;

// A map drawn with rows from the top: '#' occupied, '.' free, '?' unknown.
GridImage Draw(const std::vector<std::string>& rows, double resolution = 1.0, double origin_x = 0.0,
               double origin_y = 0.0) {
  GridImage grid;
  grid.width = static_cast<int>(rows[0].size());
  grid.height = static_cast<int>(rows.size());
  grid.resolution = resolution;
  grid.origin_x = origin_x;
  grid.origin_y = origin_y;
  for (size_t row = rows.size(); row-- > 0;) {
    for (const char cell : rows[row]) grid.occupancy.push_back(cell == '#' ? 100 : cell == '.' ? 0 : kUnknown);
  }
  return grid;
}

GridImage RandomMap(Random* random, int width, int height, double occupied, double unknown) {
  GridImage grid;
  grid.width = width;
  grid.height = height;
  grid.resolution = 0.1;
  for (int i = 0; i < width * height; ++i) {
    const double draw = random->Uniform();
    grid.occupancy.push_back(draw < occupied ? 100 : draw < occupied + unknown ? kUnknown : 0);
  }
  return grid;
}

MapMetrics Compare(const GridImage& estimate, const GridImage& reference, double tolerance, const SE2& T = SE2()) {
  return CompareMaps(estimate, reference, T, {tolerance, false}, "test");
}

TEST(MapMetricsTest, WithoutToleranceCellsAreCountedOneByOne) {
  const GridImage reference = Draw({"##..", "#..?", "#..."});
  const GridImage estimate = Draw({"#.#.", "#..#", "?..?"});
  const MapMetrics m = Compare(estimate, reference, 0.0);
  EXPECT_EQ(m.estimated_occupied, 4u);
  EXPECT_EQ(m.reference_occupied, 4u);
  EXPECT_EQ(m.estimated_right, 2u);
  EXPECT_EQ(m.reference_found, 2u);
  EXPECT_EQ(m.right, 2u);
  EXPECT_EQ(m.false_positives, 1u);
  EXPECT_EQ(m.false_negatives, 2u);  // One that the estimate calls free, one that it does not know.
  EXPECT_EQ(m.unjudged, 1u);
  EXPECT_EQ(m.true_negatives, 5u);  // Free in the reference: 7; one is a false positive, one unknown in the estimate.
  EXPECT_EQ(m.outside, 0u);
  EXPECT_DOUBLE_EQ(*m.precision, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(m.sensitivity, 2.0 / 4.0);
  EXPECT_DOUBLE_EQ(m.accuracy, 7.0 / 10.0);
}

TEST(MapMetricsTest, WithinTheToleranceCellsAreRight) {
  const GridImage reference = Draw({"#....", ".....", ".....", "....#"});
  const GridImage estimate = Draw({"..#..", ".....", ".....", "#...."});
  const MapMetrics strict = Compare(estimate, reference, 1.99);
  EXPECT_EQ(strict.estimated_right, 0u);
  EXPECT_EQ(strict.false_positives, 2u);
  EXPECT_EQ(strict.false_negatives, 2u);
  EXPECT_EQ(strict.true_negatives, 16u);
  const MapMetrics m = Compare(estimate, reference, 2.0);
  EXPECT_EQ(m.estimated_right, 1u);
  EXPECT_EQ(m.reference_found, 1u);
  EXPECT_EQ(m.right, 2u);
  EXPECT_EQ(m.false_positives, 1u);
  EXPECT_EQ(m.false_negatives, 1u);
  EXPECT_EQ(m.true_negatives, 16u);
  EXPECT_DOUBLE_EQ(m.accuracy, 18.0 / 20.0);
}

TEST(MapMetricsTest, TheDistanceIsEuclidean) {
  const GridImage reference = Draw({"....", "....", "....", "#..."}, 0.01);
  const GridImage estimate = Draw({"....", "..#.", "....", "...."}, 0.01);
  EXPECT_EQ(Compare(estimate, reference, 0.028).estimated_right, 0u);
  EXPECT_EQ(Compare(estimate, reference, 0.0283).estimated_right, 1u);
  // Three cells are within three hundredths of a metre, whatever binary fractions make of it.
  EXPECT_EQ(Compare(Draw({"...#"}, 0.01), Draw({"#..."}, 0.01), 0.03).estimated_right, 1u);
}

TEST(MapMetricsTest, AnEstimateThatIsUnknownInTheReferenceIsRightOnlyNearIt) {
  const GridImage reference = Draw({"#???"});
  const MapMetrics m = Compare(Draw({".#.#"}), reference, 1.0);
  EXPECT_EQ(m.estimated_right, 1u);
  EXPECT_EQ(m.unjudged, 1u);
  EXPECT_EQ(m.false_positives, 0u);
  EXPECT_EQ(m.true_negatives, 0u);
  EXPECT_DOUBLE_EQ(*m.precision, 1.0);
}

TEST(MapMetricsTest, BeyondTheReferenceCellsAreFalseUnlessNearItsEdge) {
  const GridImage reference = Draw({"..#", "..."}, 0.5, 10.0, 20.0);
  const GridImage estimate = Draw({"#..##", "....#"}, 0.5, 9.5, 20.0);
  const MapMetrics plain = Compare(estimate, reference, 0.0);
  EXPECT_EQ(plain.estimated_occupied, 4u);
  EXPECT_EQ(plain.outside, 3u);
  EXPECT_EQ(plain.estimated_right, 1u);
  EXPECT_EQ(plain.false_positives, 3u);
  const MapMetrics near = Compare(estimate, reference, 0.5);
  EXPECT_EQ(near.outside, 3u);
  EXPECT_EQ(near.estimated_right, 2u);
  EXPECT_EQ(near.false_positives, 2u);
  EXPECT_DOUBLE_EQ(*near.precision, 0.5);
  const MapMetrics open = CompareMaps(estimate, reference, SE2(), {0.5, true}, "test");
  EXPECT_EQ(open.outside, 3u);
  EXPECT_EQ(open.estimated_right, 2u);
  EXPECT_EQ(open.false_positives, 0u);
  EXPECT_EQ(open.unjudged, 2u);
  EXPECT_DOUBLE_EQ(*open.precision, 1.0);
}

TEST(MapMetricsTest, FarAwayEstimatesAreFalse) {
  const GridImage reference = Draw({"#."}, 0.01);
  for (const SE2& far : {SE2(1e3, 0.0, 0.3), SE2(-1e9, 1e9, 0.0)}) {
    const MapMetrics m = Compare(reference, reference, 0.5, far);
    EXPECT_GE(m.false_positives, 1u);
    EXPECT_EQ(m.outside, m.false_positives);
    EXPECT_EQ(m.estimated_right, 0u);
    EXPECT_EQ(m.false_negatives, 1u);
    EXPECT_EQ(*m.precision, 0.0);
  }
}

TEST(MapMetricsTest, CoarseCellsCoverTheFineOnesOfTheReference) {
  const GridImage estimate = Draw({"#.", "?#"}, 0.2);
  const GridImage reference = Draw({"##..", "##..", "..##", "..#."}, 0.1);
  const MapMetrics m = Compare(estimate, reference, 0.0);
  EXPECT_EQ(m.estimated_occupied, 8u);
  EXPECT_EQ(m.estimated_right, 7u);
  EXPECT_EQ(m.false_positives, 1u);
  EXPECT_EQ(m.false_negatives, 0u);
  EXPECT_EQ(m.true_negatives, 4u);
}

TEST(MapMetricsTest, FineCellsAreNotLostInTheCoarseOnesOfTheReference) {
  // A coarse cell's centre is the common corner of its four fine cells and belongs to the upper right one.
  const GridImage reference = Draw({"##.", "..."}, 0.2);
  const GridImage estimate = Draw({".#....", "....#.", "..#...", "......"}, 0.1);
  const MapMetrics m = Compare(estimate, reference, 0.0);
  EXPECT_EQ(m.estimated_occupied, 3u);
  EXPECT_EQ(m.estimated_right, 1u);
  EXPECT_EQ(m.false_positives, 2u);
  EXPECT_EQ(m.false_negatives, 1u);
  EXPECT_EQ(m.true_negatives, 2u);
  // Two in one coarse cell are one.
  EXPECT_EQ(Compare(Draw({"#.", ".#"}, 0.1), Draw({"#"}, 0.2), 0.0).estimated_occupied, 1u);
}

TEST(MapMetricsTest, AMovedMapIsMovedBack) {
  Random random(4);
  const GridImage reference = RandomMap(&random, 40, 30, 0.1, 0.1);
  // A quarter turn about the origin and a shift by whole cells turn the grid onto itself.
  GridImage estimate;
  estimate.width = reference.height;
  estimate.height = reference.width;
  estimate.resolution = reference.resolution;
  estimate.occupancy.resize(reference.occupancy.size());
  for (int y = 0; y < reference.height; ++y) {
    for (int x = 0; x < reference.width; ++x) {
      estimate.occupancy[static_cast<size_t>((reference.width - 1 - x) * estimate.width + y)] =
          reference.occupancy[static_cast<size_t>(y * reference.width + x)];
    }
  }
  // Reference (x, y) is estimate (y, 4 - x).
  const SE2 T_reference_estimate(4.0, 0.0, 0.5 * kPi);
  const MapMetrics m = Compare(estimate, reference, 0.0, T_reference_estimate);
  EXPECT_EQ(m.estimated_right, m.reference_occupied);
  EXPECT_EQ(m.estimated_occupied, m.reference_occupied);
  EXPECT_DOUBLE_EQ(m.accuracy, 1.0);
  EXPECT_LT(Compare(estimate, reference, 0.0).sensitivity, 0.5);
}

TEST(MapMetricsTest, ARotatedMapLosesNoCell) {
  // A block of 6 x 6 small cells, turned by odd angles, must cover the large block's inside.
  const GridImage reference =
      Draw({"........", ".######.", ".######.", ".######.", ".######.", ".######.", ".######.", "........"}, 0.1, -0.4,
           -0.4);
  for (const double angle : {0.1, 0.7, 2.0, -1.3}) {
    const MapMetrics m = Compare(reference, reference, 0.15, SE2(0.0, 0.0, angle));
    EXPECT_DOUBLE_EQ(m.sensitivity, 1.0) << angle;
    EXPECT_DOUBLE_EQ(*m.precision, 1.0) << angle;
    EXPECT_NEAR(static_cast<double>(m.estimated_occupied), 36.0, 8.0) << angle;
  }
}

// The definitions, taken literally.
struct Counts {
  size_t estimated, right_estimated, found, right, false_positives, false_negatives, true_negatives, outside, unjudged;
};

Counts BruteForce(const GridImage& estimate, const GridImage& reference, const SE2& T_reference_estimate,
                  double tolerance) {
  using Index = std::pair<int, int>;
  const auto value = [](const GridImage& grid, const Index& cell) -> int {
    if (cell.first < 0 || cell.second < 0 || cell.first >= grid.width || cell.second >= grid.height) return kUnknown;
    return grid.occupancy[static_cast<size_t>(cell.second * grid.width + cell.first)];
  };
  const auto centre = [](const GridImage& grid, const Index& cell) {
    return Eigen::Vector2d(grid.origin_x + (cell.first + 0.5) * grid.resolution,
                           grid.origin_y + (cell.second + 0.5) * grid.resolution);
  };
  const auto holder = [](const GridImage& grid, const Eigen::Vector2d& point) {
    return Index(static_cast<int>(std::floor((point.x() - grid.origin_x) / grid.resolution)),
                 static_cast<int>(std::floor((point.y() - grid.origin_y) / grid.resolution)));
  };
  const SE2 T_estimate_reference = T_reference_estimate.Inverse();
  std::set<Index> E;
  std::set<Index> R;
  for (int y = 0; y < estimate.height; ++y) {
    for (int x = 0; x < estimate.width; ++x) {
      if (value(estimate, {x, y}) == 100) E.insert(holder(reference, T_reference_estimate * centre(estimate, {x, y})));
    }
  }
  constexpr int kFar = 60;
  for (int y = -kFar; y < kFar; ++y) {
    for (int x = -kFar; x < kFar; ++x) {
      const Index below = holder(estimate, T_estimate_reference * centre(reference, {x, y}));
      if (value(estimate, below) == 100) E.insert({x, y});
      if (value(reference, {x, y}) == 100) R.insert({x, y});
    }
  }
  const auto is_near = [&](const Index& cell, const std::set<Index>& set) {
    for (const Index& other : set) {
      const double cells = std::hypot(cell.first - other.first, cell.second - other.second);
      if (cells * reference.resolution <= tolerance + 1e-9) return true;
    }
    return false;
  };
  Counts counts{};
  counts.estimated = E.size();
  for (const Index& cell : E) {
    const bool is_inside =
        cell.first >= 0 && cell.second >= 0 && cell.first < reference.width && cell.second < reference.height;
    if (!is_inside) ++counts.outside;
    if (is_near(cell, R)) {
      ++counts.right_estimated;
    } else if (!is_inside || value(reference, cell) == 0) {
      ++counts.false_positives;
    } else {
      ++counts.unjudged;
    }
  }
  counts.right = counts.right_estimated;
  for (const Index& cell : R) {
    const bool is_found = is_near(cell, E);
    (is_found ? counts.found : counts.false_negatives) += 1;
    if (is_found && E.count(cell) == 0) ++counts.right;
  }
  for (int y = 0; y < reference.height; ++y) {
    for (int x = 0; x < reference.width; ++x) {
      const Index below = holder(estimate, T_estimate_reference * centre(reference, {x, y}));
      if (value(reference, {x, y}) == 0 && E.count({x, y}) == 0 && value(estimate, below) == 0) {
        ++counts.true_negatives;
      }
    }
  }
  return counts;
}

TEST(MapMetricsTest, AgreesWithTheDefinitionsTakenLiterally) {
  Random random(12);
  for (int round = 0; round < 200; ++round) {
    GridImage reference = RandomMap(&random, 1 + static_cast<int>(random.Uniform(0.0, 20.0)),
                                    1 + static_cast<int>(random.Uniform(0.0, 20.0)), 0.08, random.Uniform(0.0, 0.5));
    reference.occupancy[0] = 100;
    reference.origin_x = random.Uniform(-1.0, 1.0);
    GridImage estimate = RandomMap(&random, 1 + static_cast<int>(random.Uniform(0.0, 16.0)),
                                   1 + static_cast<int>(random.Uniform(0.0, 16.0)), 0.1, random.Uniform(0.0, 0.5));
    SE2 T_reference_estimate;
    if (round % 2 == 0) {
      estimate.resolution = random.Uniform(0.03, 0.2);
      estimate.origin_x = random.Uniform(-1.0, 1.0);
      estimate.origin_y = random.Uniform(-1.0, 1.0);
      T_reference_estimate = SE2(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), random.Uniform(-kPi, kPi));
    } else {
      estimate.origin_x = reference.origin_x;  // The same grid.
    }
    const double tolerance = round % 5 == 0 ? 0.0 : random.Uniform(0.0, 0.6);
    const MapMetrics m = Compare(estimate, reference, tolerance, T_reference_estimate);
    const Counts expected = BruteForce(estimate, reference, T_reference_estimate, tolerance);
    SCOPED_TRACE("round " + std::to_string(round));
    EXPECT_EQ(m.estimated_occupied, expected.estimated);
    EXPECT_EQ(m.estimated_right, expected.right_estimated);
    EXPECT_EQ(m.reference_found, expected.found);
    EXPECT_EQ(m.right, expected.right);
    EXPECT_EQ(m.false_positives, expected.false_positives);
    EXPECT_EQ(m.false_negatives, expected.false_negatives);
    EXPECT_EQ(m.true_negatives, expected.true_negatives);
    EXPECT_EQ(m.outside, expected.outside);
    EXPECT_EQ(m.unjudged, expected.unjudged);
    EXPECT_EQ(m.reference_found + m.false_negatives, m.reference_occupied);
    EXPECT_EQ(m.estimated_right + m.false_positives + m.unjudged, m.estimated_occupied);
    EXPECT_GE(m.accuracy, 0.0);
    EXPECT_LE(m.accuracy, 1.0);
  }
}

TEST(MapMetricsTest, AnEmptyEstimateFindsNothing) {
  const MapMetrics m = Compare(Draw({"..", "??"}), Draw({"#.", ".."}), 0.0);
  EXPECT_FALSE(m.precision);
  EXPECT_EQ(m.sensitivity, 0.0);
  EXPECT_DOUBLE_EQ(m.accuracy, 0.5);
  EXPECT_EQ(m.true_negatives, 1u);
}

TEST(MapMetricsTest, WhatCannotBeCompared) {
  const GridImage good = Draw({"#."}, 0.01);
  const auto expect_error = [](const GridImage& estimate, const GridImage& reference, double tolerance,
                               const std::string& part) {
    try {
      CompareMaps(estimate, reference, SE2(), {tolerance, false}, "a.yaml against b.yaml");
      ADD_FAILURE() << "no error: " << part;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith("a.yaml against b.yaml: "));
      EXPECT_THAT(error.what(), testing::HasSubstr(part));
    }
  };
  expect_error(good, Draw({"..?"}), 0.0, "the reference map has no occupied cell");
  expect_error(good, good, -0.1, "the tolerance is -0.1 m");
  expect_error(good, good, 1.6, "150 of the reference's cells, 1.5 m");
  expect_error(good, good, std::nan(""), "the tolerance is");
  expect_error(Draw({"#"}, 1.1), good, 0.0, "too coarse");
  EXPECT_EQ(Compare(good, good, 1.5).estimated_right, 1u);
  EXPECT_EQ(Compare(Draw({"#"}, 1.0), good, 0.0).estimated_occupied, 10000u);
  EXPECT_EQ(Compare(Draw({"#"}, 1e-300), good, 0.0).estimated_right, 1u);
}

TEST(MapMetricsTest, FieldsGiveTheFigures) {
  MapMetrics m;
  m.precision = 0.1;
  m.sensitivity = 0.2;
  m.accuracy = 0.3;
  std::vector<std::pair<std::string, double>> figures;
  for (const MapMetricField& field : MapMetricFields()) figures.emplace_back(field.key, field.value(m).value());
  EXPECT_THAT(figures, testing::ElementsAre(testing::Pair("map_precision", 0.1), testing::Pair("map_sensitivity", 0.2),
                                            testing::Pair("map_accuracy", 0.3)));
  m.precision.reset();
  EXPECT_FALSE(MapMetricFields()[0].value(m));
}

}  // namespace
}  // namespace arborslam
