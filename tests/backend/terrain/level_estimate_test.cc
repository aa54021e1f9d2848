#include "backend/terrain/level_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

// Views along a path among trunks, in a map in which upright things lean by `lean`; `foliage` is the share of lines
// that say nothing.
std::vector<UprightView> Views(const Eigen::Vector2d& lean, double taper, double foliage) {
  Random random(4);
  std::vector<UprightView> views;
  for (int i = 0; i < 80; ++i) {
    UprightView view;
    view.T_map_base = SE2(0.5 * i, 0.0, random.Uniform(-kPi, kPi));
    view.tilt = {random.Uniform(-0.05, 0.05), random.Uniform(-0.05, 0.05), 0.5};
    view.tilt_when_seen = view.tilt;
    std::vector<UprightLine> lines;
    for (int k = 0; k < 15; ++k) {
      const double bearing = random.Uniform(-kPi, kPi);
      const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
      const double slope = random.Uniform() < foliage ? random.Uniform(-0.35, 0.35)
                                                      : direction.dot(view.T_map_base.rotation().transpose() * lean) +
                                                            taper + 0.05 * random.Gaussian();
      lines.push_back(
          {direction.cast<float>(), static_cast<float>(random.Uniform(1.0, 6.0)), static_cast<float>(slope), 0.1f});
    }
    view.lines = std::move(lines);
    views.push_back(view);
  }
  return views;
}

TEST(EstimateLevel, FindsTheLeanAmongFoliageWhateverTheTaper) {
  const Eigen::Vector2d lean(0.03, -0.02);
  for (const double foliage : {0.0, 0.4}) {
    const LevelEstimate level = EstimateLevel(Views(lean, 0.04, foliage));
    EXPECT_GT(level.num_places, 100u);
    EXPECT_LT(level.sigma, 0.02);
    // A part is kept back for what is not known.
    EXPECT_NEAR(level.lean.x(), lean.x(), 0.009);
    EXPECT_NEAR(level.lean.y(), lean.y(), 0.009);
  }
}

TEST(EstimateLevel, FollowsTiltsThatWereCorrectedSince) {
  std::vector<UprightView> views = Views({0.0, 0.0}, 0.0, 0.0);
  // The lines were measured with attitudes that leaned by 0.03 along the map's x.
  for (UprightView& view : views) {
    const Eigen::Vector2d lean = view.T_map_base.rotation().transpose() * Eigen::Vector2d(0.03, 0.0);
    view.tilt_when_seen.pitch = view.tilt.pitch + lean.x();
    view.tilt_when_seen.roll = view.tilt.roll - lean.y();
    std::vector<UprightLine> lines = *view.lines.Get();
    for (UprightLine& line : lines) line.slope += static_cast<float>(line.direction.cast<double>().dot(lean));
    view.lines = std::move(lines);
  }
  EXPECT_LT(EstimateLevel(views).lean.norm(), 0.006);
}

TEST(EstimateLevel, SaysNothingWithoutLines) {
  EXPECT_EQ(EstimateLevel({}).lean.norm(), 0.0);
  const LevelEstimate level = EstimateLevel(std::vector<UprightView>(3));
  EXPECT_EQ(level.lean.norm(), 0.0);
  EXPECT_EQ(level.num_places, 0u);
}

TEST(MadeUpright, TurnsTheMapAboutItsOrigin) {
  LevelEstimate level;
  level.lean = {0.1, 0.0};
  // What leans towards +x turns back towards -x: the ground at +x comes up.
  const Tilt3 far = MadeUpright({0.0, 0.0, 0.5}, SE2(10.0, 0.0, 0.0), level);
  EXPECT_NEAR(far.z, 1.5, 0.02);
  EXPECT_NEAR(far.pitch, -std::atan(0.1), 1e-9);
  EXPECT_NEAR(far.roll, 0.0, 1e-9);
  const Tilt3 turned = MadeUpright({0.0, 0.0, 0.5}, SE2(0.0, 10.0, kPi / 2.0), level);
  EXPECT_NEAR(turned.z, 0.5, 0.01);
  // Heading along +y: the lean towards +x is one to the right.
  EXPECT_NEAR(turned.roll, -std::atan(0.1), 1e-6);
  const Tilt3 same = MadeUpright({0.1, 0.2, 0.5}, SE2(3.0, 4.0, 1.0), LevelEstimate{});
  EXPECT_NEAR(same.roll, 0.1, 1e-12);
  EXPECT_NEAR(same.pitch, 0.2, 1e-12);
  EXPECT_NEAR(same.z, 0.5, 1e-12);
}

}  // namespace
}  // namespace arborslam
