#include "backend/loop/submap_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

TEST(SubmapPath, IsAsFarAsTheNearestKeyframe) {
  Random random(5);
  PoseGraph graph;
  Submap submap;
  std::vector<Eigen::Vector2d> positions;
  for (int i = 0; i < 60; ++i) {
    const SE2 pose(random.Uniform(-20.0, 20.0), random.Uniform(-5.0, 5.0), 0.1 * i);
    graph.AddNode(KeyframeId{i}, pose);
    // Every third is not the submap's.
    if (i % 3 == 0) continue;
    submap.keyframes.push_back(KeyframeId{i});
    positions.push_back(pose.translation());
  }
  const SubmapPath path(submap, graph);
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Vector2d from(random.Uniform(-40.0, 40.0), random.Uniform(-40.0, 40.0));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& position : positions) nearest = std::min(nearest, (position - from).norm());
    EXPECT_DOUBLE_EQ(path.DistanceTo(from), nearest);
    const double limited = path.DistanceTo(from, 10.0);
    if (nearest <= 10.0) {
      EXPECT_DOUBLE_EQ(limited, nearest);
    } else {
      EXPECT_GT(limited, 10.0);
    }
  }
}

TEST(SubmapPath, NothingIsNearToASubmapWithoutKeyframes) {
  const SubmapPath path{Submap(), PoseGraph()};
  EXPECT_TRUE(std::isinf(path.DistanceTo(Eigen::Vector2d::Zero())));
}

}  // namespace
}  // namespace arborslam
