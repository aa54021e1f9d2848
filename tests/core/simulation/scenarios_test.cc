#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/config/config_schema.h"
#include "core/simulation/citrus.h"
#include "core/simulation/cones.h"
#include "core/simulation/forest.h"
#include "core/simulation/orchard.h"
#include "core/simulation/vineyard.h"

namespace arborslam {
namespace {

// A scenario with its default options, as the paper describes its real counterpart.
struct Expectation {
  std::string name;
  double path_length;  // [m].
  double length;       // [m], of the rectangle around the path.
  double width;        // [m].
  double clearance;    // [m], least distance between path and solids.
  std::function<std::pair<RunOptions, Scene>(int)> make;
};

template <class Options>
std::function<std::pair<RunOptions, Scene>(int)> Maker(Scene (*make_scene)(const Options&)) {
  return [make_scene](int seed) {
    Options options;
    options.run.seed = seed;
    EXPECT_EQ(options.Validate(), "");
    // Far beams are not needed here, and the ground out there takes its time.
    options.run.lidar.max_range = 30.0;
    return std::make_pair(options.run, make_scene(options));
  };
}

std::vector<Expectation> Expectations() {
  return {{"cones", 16.0, 6.0, 2.0, 0.3, Maker<ConesOptions>(&MakeCones)},
          {"citrus", 865.0, 65.8, 48.0, 1.0, Maker<CitrusOptions>(&MakeCitrus)},
          {"vineyard", 102.0, 48.0, 5.0, 0.6, Maker<VineyardOptions>(&MakeVineyard)},
          {"orchard", 150.0, 31.4, 13.5, 0.8, Maker<OrchardOptions>(&MakeOrchard)},
          {"forest", 400.0, 0.0, 0.0, 0.5, Maker<ForestOptions>(&MakeForest)}};
}

class ScenariosTest : public testing::TestWithParam<Expectation> {};

TEST_P(ScenariosTest, PathIsThatOfTheRealCounterpart) {
  for (const int seed : {1, 2, 3}) {
    const auto [options, scene] = GetParam().make(seed);
    EXPECT_NEAR(scene.path.Length(), GetParam().path_length, 0.05 * GetParam().path_length);
    const Extent extent = ExtentOf(scene.path);
    if (GetParam().length > 0.0) {
      EXPECT_NEAR(extent.high.x() - extent.low.x(), GetParam().length, 0.1);
      EXPECT_NEAR(extent.high.y() - extent.low.y(), GetParam().width, 0.1);
    }
    const SE2 begin = scene.path.At(0.0);
    EXPECT_LT(begin.translation().norm(), 1.0);
    EXPECT_LT(std::abs(begin.theta()), 0.2);
  }
}

TEST_P(ScenariosTest, NothingStandsInTheWay) {
  for (const int seed : {1, 2, 3}) {
    auto [options, scene] = GetParam().make(seed);
    const SimulatedRun run(options, std::move(scene));
    double nearest = std::numeric_limits<double>::infinity();
    std::vector<Eigen::Vector2d> places;
    for (double time = 0.0; time < run.carrier().Duration(); time += 0.25) {
      places.emplace_back(run.carrier().PoseAt(time).translation().head<2>());
    }
    for (const Frustum& solid : run.world().solids) {
      const Eigen::Vector3d low = solid.base;
      if (low.z() > run.world().terrain.Height(low.head<2>()) + 0.9) continue;  // A limb.
      for (const Eigen::Vector2d& place : places) {
        nearest = std::min(nearest, (low.head<2>() - place).norm() - solid.base_radius);
      }
    }
    EXPECT_GT(nearest, GetParam().clearance - 0.15) << seed;
    EXPECT_LT(nearest, 6.0) << seed;
  }
}

TEST_P(ScenariosTest, MapShowsEverySolidOnTheGround) {
  auto [options, scene] = GetParam().make(1);
  const SimulatedRun run(options, std::move(scene));
  const GridImage map = run.Map();
  int seen = 0;
  for (const Frustum& solid : run.world().solids) {
    // Where its axis leaves the ground.
    const double ground = run.world().terrain.Height(solid.base.head<2>());
    if (solid.base.z() > ground + 0.01) continue;
    const Eigen::Vector3d foot = solid.base + (ground - solid.base.z()) / solid.axis.z() * solid.axis;
    const auto column = static_cast<int>(std::floor((foot.x() - map.origin_x) / map.resolution));
    const auto row = static_cast<int>(std::floor((foot.y() - map.origin_y) / map.resolution));
    if (column < 0 || column >= map.width || row < 0 || row >= map.height) continue;
    EXPECT_EQ(map.occupancy[static_cast<size_t>(row) * static_cast<size_t>(map.width) + static_cast<size_t>(column)],
              100);
    ++seen;
  }
  EXPECT_GE(seen, 10);
  const auto occupied = std::count(map.occupancy.begin(), map.occupancy.end(), 100);
  EXPECT_LT(occupied, static_cast<int64_t>(map.occupancy.size() / 10));
}

TEST_P(ScenariosTest, SweepsAreFullAndFollowFromTheSeed) {
  const auto sweep_of = [&](int seed, size_t index) {
    auto [options, scene] = GetParam().make(seed);
    options.lidar.columns = 180;
    return SimulatedRun(options, std::move(scene)).Sweep(index);
  };
  const LidarSweep one = sweep_of(1, 30);
  EXPECT_GT(one.points.size(), 180u * 16u / 4u);
  EXPECT_EQ(one.points, sweep_of(1, 30).points);
  EXPECT_NE(one.points, sweep_of(2, 30).points);
}

INSTANTIATE_TEST_SUITE_P(All, ScenariosTest, testing::ValuesIn(Expectations()),
                         [](const auto& test) { return test.param.name; });

// Every key takes part in the validation or may have any value.
template <class Options>
void ExpectRefused(const std::string& section, const std::vector<std::string>& assignments) {
  for (const std::string& assignment : assignments) {
    Options options;
    ConfigSchema schema;
    schema.AddSection(section, &options);
    schema.ApplyOverride(section + "." + assignment);
    EXPECT_NE(options.Validate(), "") << assignment;
    EXPECT_EQ(options.Validate().substr(0, assignment.find('=')), assignment.substr(0, assignment.find('=')));
  }
}

TEST(ScenarioOptionsTest, RefuseWhatCannotBe) {
  ExpectRefused<ConesOptions>("cones", {"cones=-1", "cones=41", "cone_height=0.1", "cone_radius=0.5",
                                        "background_trees=-1", "seed=-1", "motion=fly", "rings=0", "bumps=-1"});
  ExpectRefused<CitrusOptions>("citrus", {"rows=0", "row_spacing=1", "row_length=0", "tree_spacing=0.1",
                                          "missing_trees=1.5", "leaf_density=0", "headland=0.5"});
  ExpectRefused<VineyardOptions>("vineyard",
                                 {"corridors=1", "row_spacing=1.2", "row_length=0", "post_spacing=0", "vine_spacing=0",
                                  "leaf_density=0", "leaf_gaps=-1", "headland=0", "background_trees=-1"});
  ExpectRefused<OrchardOptions>("orchard", {"rows=1", "row_spacing=1", "row_length=0", "tree_spacing=0",
                                            "missing_trees=-1", "leaf_density=0", "headland=0"});
  ExpectRefused<ForestOptions>(
      "forest", {"path_length=1", "stems=-1", "stem_distance=-1", "trunk_radius=0", "bushes=-1", "leaf_density=0"});
}

}  // namespace
}  // namespace arborslam
