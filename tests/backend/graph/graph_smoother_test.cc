#include "backend/graph/graph_smoother.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include "core/io/vertex_poses.h"
#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

using Pair = std::pair<int, int>;

// Four rounds of a square of 10 m, a vertex a metre, each seen again from where it was passed a round before. Errors
// are `optimism` times what is claimed.
struct Rounds {
  static constexpr int kRound = 40;
  std::vector<SE2> truth;
  PoseGraph2 graph;

  Rounds(double optimism, uint64_t seed) {
    Random random(seed);
    SE2 pose;
    SE2 estimate;
    const auto measure = [&](int from, int to) {
      const Eigen::Matrix3d information = RandomInformation(&random, 0.05, 0.02);
      const SE2 T_from_to = truth[static_cast<size_t>(from)].Inverse() * truth[static_cast<size_t>(to)];
      graph.edges.push_back({from, to, Disturbed(T_from_to, information, optimism, &random), information});
    };
    for (int i = 0; i < 4 * kRound; ++i) {
      truth.push_back(pose);
      if (i > 0) {
        measure(i - 1, i);
        estimate = estimate * graph.edges.back().measurement;
      }
      graph.vertices[i] = estimate;
      if (i >= kRound) measure(i - kRound, i);
      pose = pose * SE2(1.0, 0.0, i % 10 == 9 ? 0.5 * kPi : 0.0);
    }
  }

  double Rmse(const PoseGraph2& smoothed) const {
    double sum = 0.0;
    for (const auto& [id, vertex] : smoothed.vertices) {
      sum += (vertex.translation() - truth[static_cast<size_t>(id)].translation()).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(truth.size()));
  }
};

// Adds `count` loops that are wrong; returns which.
std::set<Pair> AddWrongLoops(int count, uint64_t seed, PoseGraph2* graph) {
  Random random(seed);
  std::set<Pair> wrong;
  const auto size = static_cast<double>(graph->vertices.size());
  while (static_cast<int>(wrong.size()) < count) {
    const int from = static_cast<int>(size * random.Uniform());
    const int to = static_cast<int>(size * random.Uniform());
    if (to - from < 2 || !wrong.emplace(from, to).second) continue;
    const double x = random.Uniform(-10.0, 10.0);
    const double y = random.Uniform(-10.0, 10.0);
    graph->edges.push_back({from, to, SE2(x, y, random.Uniform(-3.0, 3.0)), graph->edges.front().information});
  }
  return wrong;
}

std::string GraphFile(const std::string& name) {
  const char* const folder = std::getenv("ARBORSLAM_DATA");
  return std::string(folder != nullptr ? folder : ARBORSLAM_SOURCE_DIR "/../shared/data") + "/g2o/" + name;
}

TEST(GraphSmoother, AStepIsSharedAndTheFirstVertexHeld) {
  PoseGraph2 graph;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  graph.vertices = {{3, SE2(5.0, 0.0, 0.0)}, {7, SE2(6.0, 0.0, 0.0)}};
  graph.edges = {{3, 7, SE2(1.0, 0.0, 0.0), unit}, {7, 3, SE2(-1.5, 0.0, 0.0), unit}};
  const SmoothedGraph smoothed = SmoothGraph(graph, {}, {}, 1);
  EXPECT_EQ(smoothed.held, std::vector<int>{3});
  EXPECT_EQ(smoothed.num_parts, 1u);
  EXPECT_EQ(smoothed.num_loops, 0u);  // 3 and 7 follow each other.
  EXPECT_TRUE(smoothed.graph.vertices.at(3).IsApprox(SE2(5.0, 0.0, 0.0)));
  EXPECT_TRUE(smoothed.graph.vertices.at(7).IsApprox(SE2(6.25, 0.0, 0.0), 1e-6));
  EXPECT_NEAR(smoothed.initial_chi2, 0.25, 1e-9);
  EXPECT_NEAR(smoothed.final_chi2, 0.125, 1e-9);
}

TEST(GraphSmoother, EveryPartKeepsItsFrame) {
  PoseGraph2 graph;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 7; ++i) graph.vertices[i] = SE2(2.0 * i, 1.0, 0.3);
  graph.edges = {{0, 1, SE2(1.0, 0.0, 0.0), unit}, {3, 4, SE2(1.0, 0.0, 0.0), unit}, {5, 6, SE2(1.0, 0.0, 0.0), unit}};
  graph.fixed = {4};
  const SmoothedGraph smoothed = SmoothGraph(graph, {}, {}, 1);
  EXPECT_EQ(smoothed.num_parts, 4u);
  EXPECT_EQ(smoothed.held, (std::vector<int>{0, 2, 4, 5}));
  const auto& vertices = smoothed.graph.vertices;
  for (const int id : smoothed.held) EXPECT_EQ(vertices.at(id).vector(), graph.vertices.at(id).vector()) << id;
  for (const int id : {0, 3, 5}) {
    EXPECT_TRUE((vertices.at(id) * SE2(1.0, 0.0, 0.0)).IsApprox(vertices.at(id + 1), 1e-6)) << id;
  }
  EXPECT_NEAR(smoothed.final_chi2, 0.0, 1e-9);
}

TEST(GraphSmoother, FindsTheOptimumFromAnyVertices) {
  const Rounds rounds(1.0, 4);
  SmoothingOptions plain;
  plain.robust = false;
  PoseGraph2 from_truth = rounds.graph;
  for (auto& [id, vertex] : from_truth.vertices) vertex = rounds.truth[static_cast<size_t>(id)];
  const double optimum = SmoothGraph(from_truth, plain, {}, 1).final_chi2;
  PoseGraph2 far = rounds.graph;
  Random random(9);
  for (auto& [id, vertex] : far.vertices) {
    if (id > 0) vertex = SE2(random.Uniform(-50.0, 50.0), random.Uniform(-50.0, 50.0), random.Uniform(-3.0, 3.0));
  }
  for (const PoseGraph2& graph : {rounds.graph, far}) {
    for (const SmoothingOptions& options : {SmoothingOptions(), plain}) {
      const SmoothedGraph smoothed = SmoothGraph(graph, options, {}, 1);
      EXPECT_NEAR(smoothed.final_chi2, optimum, 1e-4 * optimum);
      EXPECT_TRUE(smoothed.dropped_loops.empty());
    }
  }
}

TEST(GraphSmoother, WrongLoopsAreDroppedWhateverTheClaims) {
  for (const double optimism : {0.2, 1.0, 3.0}) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      Rounds rounds(optimism, seed);
      const double clean = rounds.Rmse(SmoothGraph(rounds.graph, {}, {}, 1).graph);
      const std::set<Pair> wrong = AddWrongLoops(20, seed, &rounds.graph);
      const SmoothedGraph smoothed = SmoothGraph(rounds.graph, {}, {}, 2);
      std::set<Pair> dropped;
      for (const PoseGraph2::Edge& edge : smoothed.dropped_loops) dropped.emplace(edge.from, edge.to);
      EXPECT_EQ(dropped, wrong) << optimism << " " << seed;
      EXPECT_NEAR(rounds.Rmse(smoothed.graph), clean, 0.1 * clean) << optimism << " " << seed;
    }
  }
}

TEST(GraphSmoother, PlainLeastSquaresDropsNothing) {
  Rounds rounds(1.0, 1);
  AddWrongLoops(20, 1, &rounds.graph);
  SmoothingOptions plain;
  plain.robust = false;
  const SmoothedGraph smoothed = SmoothGraph(rounds.graph, plain, {}, 1);
  EXPECT_TRUE(smoothed.dropped_loops.empty());
  EXPECT_EQ(smoothed.graph.edges.size(), rounds.graph.edges.size());
  EXPECT_GT(rounds.Rmse(smoothed.graph), 0.5);
}

TEST(GraphSmoother, ThreadsDoNotMatter) {
  Rounds rounds(1.0, 6);
  AddWrongLoops(20, 6, &rounds.graph);
  const SmoothedGraph one = SmoothGraph(rounds.graph, {}, {}, 1);
  const SmoothedGraph two = SmoothGraph(rounds.graph, {}, {}, 2);
  for (const auto& [id, vertex] : one.graph.vertices) EXPECT_EQ(two.graph.vertices.at(id).vector(), vertex.vector());
}

// The sum of squares of these public graphs at their optimum, which solves from the truth and from other starts find.
TEST(GraphSmoother, ReachesTheOptimumOfThePublicBenchmarks) {
  const std::pair<std::string, double> graphs[] = {{"manhattan3500.g2o", 146.0767}, {"intel.g2o", 45.0047}};
  for (const auto& [name, optimum] : graphs) {
    if (!std::filesystem::exists(GraphFile(name))) GTEST_SKIP() << GraphFile(name) << " is absent; set ARBORSLAM_DATA";
    const PoseGraph2 graph = ReadG2o(GraphFile(name));
    PoseGraph2 nowhere = graph;
    for (auto& [id, vertex] : nowhere.vertices) vertex = SE2();
    for (const PoseGraph2& start : {graph, nowhere}) {
      EXPECT_NEAR(SmoothGraph(start, {}, {}, 1).final_chi2, optimum, 1e-3 * optimum) << name;
    }
  }
}

TEST(GraphSmoother, AHundredFalseLoopsDoNotHarmManhattan) {
  const std::string path = GraphFile("manhattan3500.g2o");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set ARBORSLAM_DATA";
  const PoseGraph2 graph = ReadG2o(path);
  const double clean = SmoothGraph(graph, {}, {}, 1).final_chi2;
  // Around some of these loops the path can bend and make them fit.
  for (const uint64_t seed : {3, 7, 18}) {
    PoseGraph2 spoilt = graph;
    const std::set<Pair> wrong = AddWrongLoops(100, seed, &spoilt);
    const SmoothedGraph smoothed = SmoothGraph(spoilt, {}, {}, 1);
    size_t num_wrong = 0;
    for (const PoseGraph2::Edge& edge : smoothed.dropped_loops) num_wrong += wrong.count({edge.from, edge.to});
    EXPECT_EQ(num_wrong, wrong.size()) << "seed " << seed;
    EXPECT_LE(smoothed.dropped_loops.size(), wrong.size() + 2) << "seed " << seed;
    EXPECT_NEAR(smoothed.final_chi2, clean, 0.01 * clean) << "seed " << seed;
  }
}

}  // namespace
}  // namespace arborslam
