#include "backend/terrain/terrain_smoother.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

double Ground(double x, double y) { return 0.2 * std::sin(0.35 * x) + 0.15 * std::cos(0.3 * y); }

// The tilt over the plane through the samples.
Tilt3 LocalTilt(const std::vector<GroundSample>& samples) {
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();
  for (const GroundSample& sample : samples) mean += sample.position / static_cast<float>(samples.size());
  Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
  for (const GroundSample& sample : samples) {
    spread += (sample.position - mean) * (sample.position - mean).transpose();
  }
  Eigen::Vector3f up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(spread).eigenvectors().col(0);
  if (up.z() < 0.0f) up = -up;
  Tilt3 tilt = TiltFromUp(up.cast<double>());
  tilt.z = -up.dot(mean);
  return tilt;
}

// A lidar carried around a rectangle of 20 m x 12 m, twice, tilting at random.
struct Walk {
  std::vector<TerrainView> views;
  std::vector<Tilt3> truth;
};

Walk RandomWalk(double drift) {
  Random random(8);
  Walk walk;
  for (int i = 0; i < 128; ++i) {
    const double s = i % 64;
    const SE2 pose = s < 20   ? SE2(s, 0.0, 0.0)
                     : s < 32 ? SE2(20.0, s - 20.0, kPi / 2)
                     : s < 52 ? SE2(52.0 - s, 12.0, -kPi)
                              : SE2(0.0, 64.0 - s, -kPi / 2);
    const Tilt3 truth{random.Uniform(-0.06, 0.06), random.Uniform(-0.06, 0.06), Ground(pose.x(), pose.y()) + 0.5};
    TerrainView view;
    view.T_map_base = pose;
    const Eigen::Isometry3d T_lidar_map = Lift(pose, truth).inverse();
    std::vector<GroundSample> samples;
    for (int k = 0; k < 80; ++k) {
      const double range = random.Uniform(1.5, 8.0);
      const double bearing = random.Uniform(-kPi, kPi);
      const double x = pose.x() + range * std::cos(bearing);
      const double y = pose.y() + range * std::sin(bearing);
      const Eigen::Vector3d ground(x, y, Ground(x, y) + 0.02 * random.Gaussian());
      samples.push_back({(T_lidar_map * ground).cast<float>(), 3.0f});
    }
    view.local_tilt = LocalTilt(samples);
    view.samples = std::move(samples);
    view.tilt = truth;
    view.tilt.z += drift * i;
    view.tilt.roll += 0.5 * drift * std::sin(0.1 * i);
    walk.views.push_back(view);
    walk.truth.push_back(truth);
  }
  return walk;
}

TEST(SmoothTerrain, SpreadsTheDriftAndLevelsTheMap) {
  Walk walk = RandomWalk(0.01);
  SmoothTerrain(TerrainOptions{}, &walk.views);
  const auto num_views = static_cast<Eigen::Index>(walk.views.size());
  // The level is known as well as the slopes along the walk average out; what is left of it is a plane.
  Eigen::MatrixX3d places(num_views, 3);
  Eigen::VectorXd z_errors(num_views);
  for (Eigen::Index i = 0; i < num_views; ++i) {
    const TerrainView& view = walk.views[static_cast<size_t>(i)];
    const Tilt3& truth = walk.truth[static_cast<size_t>(i)];
    places.row(i) << 1.0, view.T_map_base.x(), view.T_map_base.y();
    z_errors[i] = view.tilt.z - truth.z;
    EXPECT_NEAR(view.tilt.roll, truth.roll, DegToRad(1.2));
    EXPECT_NEAR(view.tilt.pitch, truth.pitch, DegToRad(1.2));
  }
  const Eigen::Vector3d plane = places.colPivHouseholderQr().solve(z_errors);
  EXPECT_LT(plane.tail<2>().norm(), DegToRad(1.0));
  // 1.3 m of drift before.
  EXPECT_LT((z_errors - places * plane).cwiseAbs().maxCoeff(), 0.03);
  // The first view's height is the anchor.
  EXPECT_NEAR(walk.views.front().tilt.z, walk.truth.front().z, 1e-3);
}

TEST(SmoothTerrain, ReturnsTheGround) {
  Walk walk = RandomWalk(0.0);
  for (size_t i = 0; i < walk.views.size(); ++i) walk.views[i].local_tilt = walk.truth[i];
  const TerrainMap terrain = SmoothTerrain(TerrainOptions{}, &walk.views).terrain;
  for (size_t i = 0; i < walk.views.size(); i += 5) {
    const Eigen::Vector2d place = walk.views[i].T_map_base * Eigen::Vector2d(3.0, 0.0);
    const auto surface = terrain.At(place);
    ASSERT_TRUE(surface.has_value());
    EXPECT_NEAR(surface->z, Ground(place.x(), place.y()), 0.05);
  }
}

// Grass on level ground, seen from a straight row: the farther off, the higher it looks.
TEST(SmoothTerrain, DoesNotBowWhereFarGroundLooksHigher) {
  for (const double bowl : {3e-4, 6e-4, -3e-4}) {
    Random random(3);
    std::vector<TerrainView> views;
    for (int i = 0; i < 60; ++i) {
      TerrainView view;
      view.T_map_base = SE2(i, 0.0, 0.0);
      std::vector<GroundSample> samples;
      for (int k = 0; k < 80; ++k) {
        const double range = random.Uniform(1.5, 9.5);
        const double bearing = random.Uniform(-kPi, kPi);
        const Eigen::Vector3d point(range * std::cos(bearing), range * std::sin(bearing),
                                    bowl * range * range - 0.5 + 0.02 * random.Gaussian());
        samples.push_back({point.cast<float>(), 3.0f});
      }
      view.samples = std::move(samples);
      view.tilt.z = view.local_tilt.z = 0.5;
      views.push_back(view);
    }
    const SmoothedTerrain smoothed = SmoothTerrain(TerrainOptions{}, &views);
    double lowest = views.front().tilt.z;
    double highest = lowest;
    for (const TerrainView& view : views) {
      lowest = std::min(lowest, view.tilt.z);
      highest = std::max(highest, view.tilt.z);
      EXPECT_NEAR(view.tilt.pitch, 0.0, DegToRad(0.4));
      EXPECT_NEAR(view.tilt.roll, 0.0, DegToRad(0.4));
    }
    // A map that follows the bowls is a parabola, 0.27 m deep for the first of them.
    EXPECT_LT(highest - lowest, 0.06) << bowl;
    EXPECT_NEAR(smoothed.bias.At(9.0) - smoothed.bias.At(3.0), bowl * 72.0, 0.012);
  }
}

TEST(RangeBias, LowersSamplesAlongTheVertical) {
  const RangeBias bias{{0.0, 0.01, 0.03, 0.03, 0.05, 0.09}};
  EXPECT_NEAR(bias.At(3.0), 0.02, 1e-12);
  EXPECT_NEAR(bias.At(30.0), 0.09, 1e-12);
  EXPECT_EQ(RangeBias{}.At(3.0), 0.0);
  const Tilt3 tilt{0.3, -0.2, 0.5};
  const Eigen::Vector3d point(3.0, 0.0, -0.5);
  const std::vector<GroundSample> seen = {{(tilt.Rotation().transpose() * point).cast<float>(), 4.0f}};
  const std::vector<GroundSample> lowered = WithoutBias(bias, tilt, seen);
  ASSERT_EQ(lowered.size(), 1u);
  EXPECT_TRUE((tilt.Rotation() * lowered[0].position.cast<double>()).isApprox(Eigen::Vector3d(3.0, 0.0, -0.52), 1e-5));
  EXPECT_EQ(lowered[0].weight, 4.0f);
}

TEST(SmoothTerrain, TakesNoViewsAndViewsWithoutGround) {
  std::vector<TerrainView> views;
  EXPECT_EQ(SmoothTerrain(TerrainOptions{}, &views).terrain.num_cells(), 0u);
  views.resize(3);
  views[1].tilt = views[1].local_tilt = {0.1, 0.2, 0.7};
  EXPECT_EQ(SmoothTerrain(TerrainOptions{}, &views).terrain.num_cells(), 0u);
  EXPECT_NEAR(views[1].tilt.roll, 0.1, 1e-9);
  EXPECT_NEAR(views[1].tilt.pitch, 0.2, 1e-9);
  EXPECT_NEAR(views[1].tilt.z, 0.7, 1e-9);
}

TEST(TerrainOptions, RefusesWhatMakesNoSense) {
  TerrainOptions options;
  EXPECT_EQ(options.Validate(), "");
  options.node_spacing = 0.0;
  EXPECT_NE(options.Validate().find("node_spacing"), std::string::npos);
  options = TerrainOptions{};
  options.slope_sigma = -1.0;
  EXPECT_NE(options.Validate().find("slope_sigma"), std::string::npos);
}

}  // namespace
}  // namespace arborslam
