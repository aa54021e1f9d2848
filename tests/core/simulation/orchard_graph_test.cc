#include "core/simulation/orchard_graph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

TEST(OrchardGraphOptions, ValuesOutOfRangeAreNamed) {
  OrchardGraphOptions options;
  EXPECT_EQ(options.Validate(), "");
  options.num_keyframes = 1;
  EXPECT_EQ(options.Validate().substr(0, 13), "num_keyframes");
  options = {};
  options.loop_rotation = 0.0;
  EXPECT_EQ(options.Validate().substr(0, 13), "loop_rotation");
}

TEST(OrchardGraph, MeasurementsErrAsTheyClaim) {
  OrchardGraphOptions options;
  options.num_keyframes = 2000;
  const OrchardGraph run = SimulateOrchardGraph(options);
  ASSERT_EQ(run.truth.size(), 2040u);
  ASSERT_EQ(run.graph.vertices.size(), 2040u);
  ASSERT_LT(run.first_loop, run.graph.edges.size());
  double chi2[2] = {0.0, 0.0};
  double count[2] = {0.0, 0.0};
  for (size_t i = 0; i < run.graph.edges.size(); ++i) {
    const PoseGraph2::Edge& edge = run.graph.edges[i];
    const SE2 T_from_to = run.truth[static_cast<size_t>(edge.from)].Inverse() * run.truth[static_cast<size_t>(edge.to)];
    const Eigen::Vector3d error = (edge.measurement.Inverse() * T_from_to).vector();
    if (error.norm() == 0.0) continue;  // A submap's anchor.
    const size_t kind = i < run.first_loop ? 0 : 1;
    chi2[kind] += error.dot(edge.information * error);
    count[kind] += 3.0;
    if (kind == 1) {
      EXPECT_LE(T_from_to.translation().norm(), options.loop_reach);
    }
  }
  for (const size_t kind : {0, 1}) {
    EXPECT_GT(count[kind], 500.0);
    EXPECT_NEAR(chi2[kind] / count[kind], 1.0, 5.0 * std::sqrt(2.0 / count[kind]));
  }
}

TEST(OrchardGraph, TheRunAloneDriftsAndFollowsTheSeed) {
  OrchardGraphOptions options;
  const OrchardGraph run = SimulateOrchardGraph(options);
  EXPECT_EQ(run.graph.vertices.at(0).vector(), run.truth[0].vector());
  EXPECT_GT((run.graph.vertices.at(999).translation() - run.truth[999].translation()).norm(), 0.05);
  EXPECT_EQ(SimulateOrchardGraph(options).graph.vertices.at(999).vector(), run.graph.vertices.at(999).vector());
  options.seed = 2;
  EXPECT_NE(SimulateOrchardGraph(options).graph.vertices.at(999).vector(), run.graph.vertices.at(999).vector());
}

}  // namespace
}  // namespace arborslam
