#include "frontend/tracking/terrain_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

double Ground(double x, double y) { return 0.3 * std::sin(0.3 * x) + 0.2 * std::cos(0.25 * y + 1.0); }

// The ground around a lidar, in its own frame.
std::vector<GroundSample> Samples(const SE2& pose, const Tilt3& tilt, double noise, Random* random) {
  const Eigen::Isometry3d T_lidar_map = Lift(pose, tilt).inverse();
  std::vector<GroundSample> samples;
  for (int i = 0; i < 120; ++i) {
    const double range = random->Uniform(1.5, 9.0);
    const double bearing = random->Uniform(-kPi, kPi);
    const double x = pose.x() + range * std::cos(bearing);
    const double y = pose.y() + range * std::sin(bearing);
    samples.push_back(
        {(T_lidar_map * Eigen::Vector3d(x, y, Ground(x, y) + noise * random->Gaussian())).cast<float>(), 5.0f});
  }
  return samples;
}

TerrainMap KnownGround(Random* random) {
  TerrainMap terrain(1.0);
  for (int i = 0; i < 100000; ++i) {
    const double x = random->Uniform(-20.0, 20.0);
    const double y = random->Uniform(-20.0, 20.0);
    terrain.Insert({x, y, Ground(x, y)}, 1.0);
  }
  return terrain;
}

TEST(FitToTerrain, FindsTiltAndHeightOnUnevenGround) {
  Random random(5);
  const TerrainMap terrain = KnownGround(&random);
  for (int i = 0; i < 50; ++i) {
    const SE2 pose(random.Uniform(-8.0, 8.0), random.Uniform(-8.0, 8.0), random.Uniform(-kPi, kPi));
    const Tilt3 truth{random.Uniform(-0.15, 0.15), random.Uniform(-0.15, 0.15), random.Uniform(0.2, 1.0)};
    Tilt3 initial = truth;
    initial.roll += random.Uniform(-0.06, 0.06);
    initial.pitch += random.Uniform(-0.06, 0.06);
    initial.z += random.Uniform(-0.2, 0.2);
    std::vector<GroundSample> samples = Samples(pose, truth, 0.02, &random);
    // Grass on every eighth patch.
    const Eigen::Vector3d up = truth.Rotation().row(2).transpose();
    for (size_t k = 0; k < samples.size(); k += 8) samples[k].position += (0.25 * up).cast<float>();
    const TerrainFit fit = FitToTerrain(samples, terrain, pose, initial);
    EXPECT_NEAR(fit.tilt.roll, truth.roll, DegToRad(0.5));
    EXPECT_NEAR(fit.tilt.pitch, truth.pitch, DegToRad(0.5));
    EXPECT_NEAR(fit.tilt.z, truth.z, 0.03);
    EXPECT_GT(fit.num_matched, 100);
  }
}

TEST(FitToTerrain, KeepsTheInitialTiltWithoutTerrainOrSamples) {
  Random random(6);
  const Tilt3 initial{0.05, -0.03, 0.6};
  const TerrainFit unknown = FitToTerrain(Samples(SE2(), initial, 0.0, &random), TerrainMap(1.0), SE2(), initial);
  const TerrainFit empty = FitToTerrain({}, KnownGround(&random), SE2(), initial);
  for (const TerrainFit& fit : {unknown, empty}) {
    EXPECT_EQ(fit.num_matched, 0);
    EXPECT_DOUBLE_EQ(fit.tilt.roll, initial.roll);
    EXPECT_DOUBLE_EQ(fit.tilt.pitch, initial.pitch);
    EXPECT_DOUBLE_EQ(fit.tilt.z, initial.z);
  }
}

}  // namespace
}  // namespace arborslam
