#include "frontend/projection/sweep_projection.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr float kColumnWidth = static_cast<float>(DegToRad(0.4));
constexpr float kLidarHeight = 0.6f;

// Returns by bearing [deg], range [m] and height [m].
struct Returns {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> heights;

  void Add(double bearing, double range, double height) {
    points.emplace_back(static_cast<float>(range * std::cos(DegToRad(bearing))),
                        static_cast<float>(range * std::sin(DegToRad(bearing))),
                        static_cast<float>(height - kLidarHeight));
    heights.push_back(static_cast<float>(height));
  }
  // A thing that fills some columns, three rings high.
  void AddPost(double bearing, double range, int columns = 3, double bottom = 0.4, double step = 0.1) {
    for (int column = 0; column < columns; ++column) {
      for (int ring = 0; ring < 3; ++ring) Add(bearing + 0.4 * column, range, bottom + step * ring);
    }
  }
};

PlanarScan Project(const Returns& returns, const SweepProjectionOptions& options, float canopy = 1.0f,
                   const Eigen::Matrix3f& rotation = Eigen::Matrix3f::Identity()) {
  SweepProjection projection(options);
  return projection.Project({&returns.points, &returns.heights, kLidarHeight, canopy, kColumnWidth}, rotation);
}

float TotalWeight(const PlanarScan& scan) {
  float sum = 0.0f;
  for (const float weight : scan.weights) sum += weight;
  return sum;
}

TEST(SweepProjectionTest, HeightLikelihoodIsThatOfThePaper) {
  const double canopy = 1.3;
  const double lambda = std::log(2.0) / canopy;
  EXPECT_NEAR(HeightLikelihood(0.0, canopy), lambda, 1e-12);
  EXPECT_NEAR(HeightLikelihood(0.7, canopy), lambda * std::exp(-lambda * 0.7), 1e-12);
  EXPECT_EQ(HeightLikelihood(-0.01, canopy), 0.0);
  // Eq. 5 is a density.
  double integral = 0.0;
  for (double z = 0.0005; z < 40.0; z += 0.001) integral += 0.001 * HeightLikelihood(z, canopy);
  EXPECT_NEAR(integral, 1.0, 1e-6);
}

TEST(SweepProjectionTest, KeepsWhatEquationSixKeeps) {
  SweepProjectionOptions options;
  options.ground_margin = 0.0;
  options.ground_growth = 0.0;
  for (const double canopy : {0.7, 1.0, 1.9}) {
    for (double height = -0.305; height < 2.5; height += 0.05) {
      Returns returns;
      returns.AddPost(20.0, 4.0, 3, height, 0.0);
      const bool expected = HeightLikelihood(height, canopy) >= MinHeightLikelihood(canopy);
      const PlanarScan scan = Project(returns, options, static_cast<float>(canopy));
      EXPECT_EQ(!scan.points.empty(), expected) << height << " below a canopy of " << canopy;
    }
  }
}

TEST(SweepProjectionTest, PutsPointsWhereThingsAre) {
  Returns returns;
  returns.AddPost(30.0, 5.0);
  returns.AddPost(-100.0, 8.0);
  SweepProjectionOptions options;
  options.point_spacing = 0.0;
  const PlanarScan scan = Project(returns, options);
  ASSERT_EQ(scan.points.size(), 6u);
  ASSERT_EQ(scan.weights.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(scan.weights[i], 3.0f);
    const double bearing = DegToRad((i < 3 ? -100.0 : 30.0) + 0.4 * static_cast<double>(i % 3));
    const Eigen::Vector2d expected = (i < 3 ? 8.0 : 5.0) * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    EXPECT_LT((scan.points[i].cast<double>() - expected).norm(), 1e-4);
  }
  EXPECT_FALSE(scan.point_rays_are_free);
}

TEST(SweepProjectionTest, MergesNeighbours) {
  Returns returns;
  returns.AddPost(30.0, 2.0, 6);  // 1.4 cm between columns.
  SweepProjectionOptions options;
  options.point_spacing = 0.03;
  const PlanarScan scan = Project(returns, options);
  EXPECT_GE(scan.points.size(), 2u);
  EXPECT_LE(scan.points.size(), 3u);
  EXPECT_EQ(TotalWeight(scan), 18.0f);
}

TEST(SweepProjectionTest, TurnsIntoTheBaseFrame) {
  Returns returns;
  returns.AddPost(0.0, 5.0);
  const Eigen::Matrix3f rotation =
      (Eigen::AngleAxisf(0.1f, Eigen::Vector3f::UnitY()) * Eigen::AngleAxisf(-0.2f, Eigen::Vector3f::UnitX()))
          .toRotationMatrix();
  SweepProjectionOptions options;
  options.point_spacing = 1.0;
  const PlanarScan scan = Project(returns, options, 1.0f, rotation);
  ASSERT_EQ(scan.points.size(), 1u);
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& point : returns.points) mean += rotation * point / 9.0f;
  EXPECT_LT((scan.points[0] - mean.head<2>()).norm(), 1e-4f);
}

TEST(SweepProjectionTest, MasksRangeBearingAndGround) {
  Returns returns;
  returns.AddPost(0.0, 0.4);            // The robot.
  returns.AddPost(10.0, 25.0);          // Far.
  returns.AddPost(170.0, 3.0);          // Behind.
  returns.AddPost(50.0, 3.0, 3, 0.02);  // Grass, of which the uppermost returns stay.
  SweepProjectionOptions options;
  options.max_bearing = 2.8;
  options.point_spacing = 1.0;
  const PlanarScan scan = Project(returns, options);
  ASSERT_EQ(scan.points.size(), 1u);
  EXPECT_EQ(scan.weights[0], 3.0f);
  options.max_bearing = 3.15;
  EXPECT_EQ(Project(returns, options).points.size(), 2u);
  options.ground_margin = 0.3;
  EXPECT_EQ(Project(returns, options).points.size(), 1u);
  options.ground_margin = 0.18;
  options.ground_growth = 0.1;
  EXPECT_EQ(Project(returns, options).points.size(), 1u);
}

TEST(SweepProjectionTest, TellsTrunksFromLeaves) {
  Random random(1);
  Returns returns;
  // A hedge around the lidar, three rings of it, and trunks before it, each of six columns.
  constexpr int kTrunks = 20;
  for (int column = 0; column < 900; ++column) {
    const bool is_trunk = column % 45 >= 20 && column % 45 < 26;
    for (int ring = 0; ring < 3; ++ring) {
      returns.Add(0.4 * (column + 0.5) - 180.0, is_trunk ? 3.0 : 4.0 + random.Exponential(), 0.3 + 0.1 * ring);
    }
  }
  const PlanarScan scan = Project(returns, SweepProjectionOptions());
  double on_trunks = 0.0;
  std::vector<bool> found(kTrunks, false);
  for (size_t i = 0; i < scan.points.size(); ++i) {
    if (std::abs(scan.points[i].norm() - 3.0f) > 0.05f) continue;
    on_trunks += 1.0;
    const double bearing = RadToDeg(std::atan2(scan.points[i].y(), scan.points[i].x()));
    found[static_cast<size_t>(std::clamp((bearing + 180.0) / 18.0, 0.0, kTrunks - 1.0))] = true;
  }
  for (int trunk = 0; trunk < kTrunks; ++trunk) EXPECT_TRUE(found[static_cast<size_t>(trunk)]) << trunk;
  EXPECT_GT(on_trunks, 0.8 * static_cast<double>(scan.points.size()));
}

TEST(SweepProjectionTest, FindsTheFeetOfTrunksInGrass) {
  Random random(4);
  Returns returns;
  // Grass all around, and every 36 degrees a trunk of six columns of which leaves leave one ring.
  constexpr int kTrunks = 10;
  for (int column = 0; column < 900; ++column) {
    const bool is_trunk = column % 90 >= 40 && column % 90 < 46;
    const double range = is_trunk ? 6.0 + 0.01 * random.Gaussian() : 5.0 + random.Exponential();
    returns.Add(0.4 * (column + 0.5) - 180.0, range, 0.16);
  }
  const PlanarScan scan = Project(returns, SweepProjectionOptions());
  std::vector<bool> found(kTrunks, false);
  size_t num_elsewhere = 0;
  for (const Eigen::Vector2f& point : scan.points) {
    const double column = (RadToDeg(std::atan2(point.y(), point.x())) + 180.0) / 0.4;
    const bool is_trunk = std::abs(std::fmod(column, 90.0) - 43.0) < 4.0 && std::abs(point.norm() - 6.0f) < 0.1f;
    if (is_trunk) found[static_cast<size_t>(std::clamp(column / 90.0, 0.0, kTrunks - 1.0))] = true;
    num_elsewhere += is_trunk ? 0 : 1;
  }
  for (int trunk = 0; trunk < kTrunks; ++trunk) EXPECT_TRUE(found[static_cast<size_t>(trunk)]) << trunk;
  EXPECT_LT(num_elsewhere, 30u);
}

TEST(SweepProjectionTest, TakesNoRingOnMisjudgedGroundForAThing) {
  Random random(5);
  Returns returns;
  for (int column = 0; column < 900; ++column) {
    returns.Add(0.4 * (column + 0.5) - 180.0, 6.0 + 0.01 * random.Gaussian(), 0.16);
  }
  EXPECT_TRUE(Project(returns, SweepProjectionOptions()).points.empty());
}

TEST(SweepProjectionTest, KeepsTheBestOfLeavesWhereThereIsNothingElse) {
  Random random(2);
  Returns returns;
  for (int column = 0; column < 900; ++column) {
    for (int ring = 0; ring < 3; ++ring) {
      returns.Add(0.4 * column - 180.0, 4.0 + random.Exponential(), 0.3 + 0.2 * ring);
    }
  }
  const size_t num_points = Project(returns, SweepProjectionOptions()).points.size();
  EXPECT_GE(num_points, 30u);
  EXPECT_LE(num_points, 600u);
}

// Ground as a VLP-16 at kLidarHeight sees it, up to a range.
void AddGround(double max_range, Returns* returns) {
  for (int column = 0; column < 900; ++column) {
    for (const double below : {15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0}) {
      const double range = kLidarHeight / std::tan(DegToRad(below));
      if (range < max_range) returns->Add(0.4 * column - 180.0, range, 0.0);
    }
  }
}

TEST(SweepProjectionTest, RaysAreFreeWhereTheGroundWasSeen) {
  Returns returns;
  AddGround(12.0, &returns);
  const PlanarScan scan = Project(returns, SweepProjectionOptions());
  EXPECT_TRUE(scan.points.empty());
  EXPECT_GT(scan.free_ends.size(), 700u);
  for (const Eigen::Vector2f& end : scan.free_ends) EXPECT_NEAR(end.norm(), 0.6 / std::tan(DegToRad(3.0)), 0.4);
}

TEST(SweepProjectionTest, RaysEndBeforeWhatStandsThere) {
  Returns returns;
  AddGround(12.0, &returns);
  returns.AddPost(40.0, 3.0, 5);
  const PlanarScan scan = Project(returns, SweepProjectionOptions());
  int num_towards = 0;
  for (const Eigen::Vector2f& end : scan.free_ends) {
    const double bearing = RadToDeg(std::atan2(end.y(), end.x()));
    if (bearing < 40.0 || bearing > 41.6) continue;
    ++num_towards;
    EXPECT_LT(end.norm(), 2.9f);
    EXPECT_GT(end.norm(), 2.5f);
  }
  EXPECT_GT(num_towards, 0);
}

TEST(SweepProjectionTest, RaysOverLowThingsAreNotFree) {
  // Far returns at the lidar's height say nothing of what is below.
  Returns returns;
  for (int column = 0; column < 900; ++column) returns.Add(0.4 * column - 180.0, 10.0, 0.6);
  EXPECT_TRUE(Project(returns, SweepProjectionOptions()).free_ends.empty());
}

TEST(SweepProjectionTest, NothingGivesNothing) {
  const PlanarScan scan = Project(Returns(), SweepProjectionOptions());
  EXPECT_TRUE(scan.points.empty());
  EXPECT_TRUE(scan.weights.empty());
  EXPECT_TRUE(scan.free_ends.empty());
  for (int size = 1; size <= 3; ++size) {
    Returns returns;
    for (int i = 0; i < size; ++i) returns.Add(10.0, 5.0, 0.5);
    EXPECT_LE(Project(returns, SweepProjectionOptions()).points.size(), 1u);
  }
}

TEST(SweepProjectionTest, RefusesOptionsOutOfRange) {
  EXPECT_EQ(SweepProjectionOptions().Validate(), "");
  const auto violates = [](auto change, const std::string& key) {
    SweepProjectionOptions options;
    change(&options);
    return options.Validate().substr(0, key.size()) == key;
  };
  EXPECT_TRUE(violates([](auto* o) { o->min_range = -1.0; }, "min_range"));
  EXPECT_TRUE(violates([](auto* o) { o->max_range = 0.1; }, "max_range"));
  EXPECT_TRUE(violates([](auto* o) { o->max_bearing = 4.0; }, "max_bearing"));
  EXPECT_TRUE(violates([](auto* o) { o->ground_margin = std::nan(""); }, "ground_margin"));
  EXPECT_TRUE(violates([](auto* o) { o->ground_growth = 1.0; }, "ground_growth"));
  EXPECT_TRUE(violates([](auto* o) { o->mean_canopy_height = -1.0; }, "mean_canopy_height"));
  EXPECT_TRUE(violates([](auto* o) { o->column_width = 10.0; }, "column_width"));
  EXPECT_TRUE(violates([](auto* o) { o->column_depth = -0.1; }, "column_depth"));
  EXPECT_TRUE(violates([](auto* o) { o->point_spacing = 2.0; }, "point_spacing"));
}

}  // namespace
}  // namespace arborslam
