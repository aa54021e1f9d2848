#include "backend/graph/pose_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/io/g2o.h"
#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

using Kind = Constraint::Kind;

Eigen::Matrix3d Diagonal(double translation_sigma, double rotation_sigma) {
  const double t = 1.0 / (translation_sigma * translation_sigma);
  return Eigen::Vector3d(t, t, 1.0 / (rotation_sigma * rotation_sigma)).asDiagonal();
}

double Rmse(const PoseGraph& graph, const std::vector<SE2>& reference) {
  double sum = 0.0;
  for (size_t i = 0; i < reference.size(); ++i) {
    const SE2& pose = graph.Pose(KeyframeId{static_cast<int>(i)});
    sum += (pose.translation() - reference[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(reference.size()));
}

std::vector<SE2> KeyframePoses(const PoseGraph& graph) {
  std::vector<SE2> poses;
  for (const auto& [id, pose] : graph.poses()) {
    if (id.kind == NodeId::Kind::kKeyframe) poses.push_back(pose);
  }
  return poses;
}

double WeightedError(const PoseGraph& graph, const Constraint& constraint) {
  const SE2 T_from_to = graph.Pose(constraint.from).Inverse() * graph.Pose(constraint.to);
  const Eigen::Vector3d error = (constraint.T_from_to.Inverse() * T_from_to).vector();
  return std::sqrt(error.dot(constraint.information * error));
}

// The sum of all squared weighted errors, without a robust loss.
double ChiSquare(const PoseGraph& graph) {
  double sum = 0.0;
  for (const Constraint& constraint : graph.constraints()) sum += std::pow(WeightedError(graph, constraint), 2);
  return sum;
}

using Pair = std::pair<int, int>;
std::multiset<Pair> PairsOf(const std::vector<Constraint>& constraints) {
  std::multiset<Pair> pairs;
  for (const Constraint& constraint : constraints) pairs.emplace(constraint.from.value, constraint.to.value);
  return pairs;
}

TEST(PoseGraph, DropsTheLoopsThatAreCalledWrongAndNothingElse) {
  PoseGraph graph;
  for (int i = 0; i < 4; ++i) graph.AddNode(KeyframeId{i}, SE2(i, 0.0, 0.0));
  const auto add = [&graph](int from, int to, Kind kind) {
    graph.AddConstraint({KeyframeId{from}, KeyframeId{to}, SE2(), Diagonal(0.1, 0.1), kind});
  };
  add(0, 1, Kind::kMotion);
  add(0, 2, Kind::kLoop);
  add(1, 3, Kind::kLoop);
  add(1, 2, Kind::kSubmap);
  add(0, 3, Kind::kLoop);
  const std::vector<Constraint> dropped = graph.Remove([](const Constraint& constraint) {
    return constraint.kind == Kind::kLoop && constraint.from == NodeId(KeyframeId{0});
  });
  ASSERT_EQ(dropped.size(), 2u);
  EXPECT_EQ(dropped[0].to, NodeId(KeyframeId{2}));
  EXPECT_EQ(dropped[1].to, NodeId(KeyframeId{3}));
  EXPECT_EQ(PairsOf(graph.constraints()), (std::multiset<Pair>{{0, 1}, {1, 2}, {1, 3}}));
  EXPECT_EQ(graph.Pose(KeyframeId{3}).vector(), Eigen::Vector3d(3.0, 0.0, 0.0));
}

TEST(PoseGraphOptions, ValuesOutOfRangeAreNamed) {
  PoseGraphOptions options;
  EXPECT_EQ(options.Validate(), "");
  options.loop_gate = 0.0;
  EXPECT_EQ(options.Validate().substr(0, 9), "loop_gate");
  options.loop_gate = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(options.Validate().substr(0, 9), "loop_gate");
  options.max_iterations = 0;
  EXPECT_EQ(options.Validate().substr(0, 14), "max_iterations");
}

TEST(PoseGraph, NothingToDoIsNoError) {
  PoseGraph empty;
  const PoseGraphSummary summary = empty.Optimize({}, 1);
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_TRUE(empty.poses().empty());

  PoseGraph single;
  single.AddNode(KeyframeId{0}, SE2(1.0, 2.0, 3.0));
  single.Optimize({}, 2);
  EXPECT_EQ(single.Pose(KeyframeId{0}).vector(), SE2(1.0, 2.0, 3.0).vector());
}

TEST(PoseGraph, ALoopSharesItsErrorAlongTheWay) {
  // Two steps of 1 m and a loop that says 2.3 m, all equally sure: each takes a third of the 0.3 m.
  for (const Kind kind : {Kind::kMotion, Kind::kLoop}) {
    PoseGraph graph;
    for (int i = 0; i < 3; ++i) graph.AddNode(KeyframeId{i}, SE2(i, 0.0, 0.0));
    const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
    graph.AddConstraint({KeyframeId{0}, KeyframeId{1}, SE2(1.0, 0.0, 0.0), unit, Kind::kMotion});
    graph.AddConstraint({KeyframeId{1}, KeyframeId{2}, SE2(1.0, 0.0, 0.0), unit, Kind::kMotion});
    graph.AddConstraint({KeyframeId{0}, KeyframeId{2}, SE2(2.3, 0.0, 0.0), unit, kind});
    const PoseGraphSummary summary = graph.Optimize({}, 1);
    // So far within the gate, a loop counts like any other constraint.
    const double tolerance = kind == Kind::kLoop ? 1e-4 : 1e-7;
    EXPECT_TRUE(graph.Pose(KeyframeId{1}).IsApprox(SE2(1.1, 0.0, 0.0), tolerance));
    EXPECT_TRUE(graph.Pose(KeyframeId{2}).IsApprox(SE2(2.2, 0.0, 0.0), tolerance));
    EXPECT_NEAR(summary.initial_cost, 0.5 * 0.09, tolerance);
    EXPECT_NEAR(summary.final_cost, 0.5 * 0.03, tolerance);
    EXPECT_TRUE(summary.dropped_loops.empty());
    EXPECT_EQ(graph.constraints().size(), 3u);
  }
}

TEST(PoseGraph, ASquareCloses) {
  // Four steps that turn by 90 degrees, from poses that have drifted; ends where it began.
  const SE2 step(1.0, 0.0, kPi / 2.0);
  PoseGraph graph;
  SE2 drifted;
  for (int i = 0; i < 4; ++i) {
    graph.AddNode(KeyframeId{i}, drifted);
    drifted = drifted * SE2(1.1, 0.05, kPi / 2.0 + 0.1);
  }
  for (int i = 0; i < 3; ++i) {
    graph.AddConstraint({KeyframeId{i}, KeyframeId{i + 1}, step, Diagonal(0.1, 0.1), Kind::kSubmap});
  }
  graph.AddConstraint({KeyframeId{3}, KeyframeId{0}, step, Diagonal(0.1, 0.1), Kind::kLoop});
  const PoseGraphSummary summary = graph.Optimize({}, 1);
  EXPECT_NEAR(summary.final_cost, 0.0, 1e-9);
  EXPECT_TRUE(graph.Pose(KeyframeId{2}).IsApprox(SE2(1.0, 1.0, -kPi), 1e-5) ||
              graph.Pose(KeyframeId{2}).IsApprox(SE2(1.0, 1.0, kPi - 1e-9), 1e-5));
  EXPECT_TRUE(graph.Pose(KeyframeId{3}).IsApprox(SE2(0.0, 1.0, -kPi / 2.0), 1e-5));
}

TEST(PoseGraph, TheFirstKeyframeHoldsTheFrame) {
  // The same graph, moved: its optimum moves alike, the first keyframe not at all, whatever was added first.
  const SE2 T_moved_map(100.0, -30.0, 2.5);
  std::vector<PoseGraph> graphs(2);
  for (int g = 0; g < 2; ++g) {
    Random random(7);
    const SE2 T = g == 0 ? SE2() : T_moved_map;
    PoseGraph& graph = graphs[static_cast<size_t>(g)];
    graph.AddNode(SubmapId{0}, T * SE2(0.2, 0.1, 0.1));
    for (int i = 9; i >= 0; --i) graph.AddNode(KeyframeId{i}, T * SE2(i + 0.1 * random.Gaussian(), 0.0, 0.0));
    for (int i = 0; i < 10; ++i) {
      const Eigen::Matrix3d information = RandomInformation(&random, 0.05, 0.02);
      graph.AddConstraint({SubmapId{0}, KeyframeId{i}, Disturbed(SE2(i, 0.0, 0.0), information, 1.0, &random),
                           information, Kind::kSubmap});
      if (i == 0) continue;
      graph.AddConstraint({KeyframeId{i - 1}, KeyframeId{i}, Disturbed(SE2(1.0, 0.0, 0.0), information, 1.0, &random),
                           information, Kind::kMotion});
    }
    const SE2 first = graph.Pose(KeyframeId{0});
    graph.Optimize({}, 1);
    EXPECT_EQ(graph.Pose(KeyframeId{0}).vector(), first.vector());
  }
  for (const auto& [id, pose] : graphs[0].poses()) {
    EXPECT_TRUE(graphs[1].Pose(id).IsApprox(T_moved_map * pose, 1e-5)) << id;
  }
}

TEST(PoseGraph, WhatIsNotConnectedStays) {
  PoseGraph graph;
  for (int i = 0; i < 5; ++i) graph.AddNode(KeyframeId{i}, SE2(2.0 * i, 1.0, 0.5));
  graph.AddConstraint({KeyframeId{0}, KeyframeId{1}, SE2(1.0, 0.0, 0.0), Diagonal(0.1, 0.1), Kind::kMotion});
  // 2 is alone; 3 and 4 know each other, but not where they are.
  graph.AddConstraint({KeyframeId{3}, KeyframeId{4}, SE2(1.0, 0.0, 0.0), Diagonal(0.1, 0.1), Kind::kMotion});
  const PoseGraphSummary summary = graph.Optimize({}, 1);
  EXPECT_NEAR(summary.final_cost, 0.0, 1e-6);
  EXPECT_TRUE(graph.Pose(KeyframeId{1}).IsApprox(graph.Pose(KeyframeId{0}) * SE2(1.0, 0.0, 0.0), 1e-5));
  EXPECT_TRUE(graph.Pose(KeyframeId{2}).IsApprox(SE2(4.0, 1.0, 0.5)));
  EXPECT_TRUE((graph.Pose(KeyframeId{3}) * SE2(1.0, 0.0, 0.0)).IsApprox(graph.Pose(KeyframeId{4}), 1e-4));
  EXPECT_LT((graph.Pose(KeyframeId{3}).translation() - Eigen::Vector2d(6.0, 1.0)).norm(), 2.0);
}

TEST(PoseGraph, InformationMayBeSingular) {
  PoseGraph graph;
  for (int i = 0; i < 3; ++i) graph.AddNode(KeyframeId{i}, SE2(i, 0.3 * i, 0.1 * i));
  const Eigen::Matrix3d no_y = Eigen::Vector3d(100.0, 0.0, 100.0).asDiagonal();
  graph.AddConstraint({KeyframeId{0}, KeyframeId{1}, SE2(1.0, 9.0, 0.0), no_y, Kind::kSubmap});
  graph.AddConstraint({KeyframeId{1}, KeyframeId{2}, SE2(1.0, 9.0, 0.0), no_y, Kind::kLoop});
  graph.Optimize({}, 1);
  EXPECT_TRUE(graph.Pose(KeyframeId{2}).vector().allFinite());
  EXPECT_NEAR(graph.Pose(KeyframeId{2}).x(), 2.0, 1e-4);
  EXPECT_NEAR(graph.Pose(KeyframeId{2}).theta(), 0.0, 1e-4);
  EXPECT_EQ(graph.constraints().size(), 2u);
}

// Two rounds along an oval, each 100 keyframes, and submaps that begin on the way. Steps are known to 1 cm and 5 mrad,
// so that the path drifts by metres. Loops: keyframes of one round seen in submaps of the other, known to about 1 cm
// and 2 mrad; their errors are `optimism` times what they claim.
struct Orchard {
  PoseGraph graph;
  std::vector<SE2> truth;
  std::multiset<Pair> wrong;
  size_t num_loops = 0;

  Orchard(double optimism, double wrong_share, uint64_t seed) {
    constexpr int kPerRound = 100;
    const Eigen::Matrix3d step_information = Diagonal(0.01, 0.005);
    Random random(seed);
    std::vector<SE2> estimate;
    for (int i = 0; i < 2 * kPerRound; ++i) {
      const double angle = 2.0 * kPi * i / kPerRound;
      const SE2 pose(20.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle),
                     std::atan2(10.0 * std::sin(angle), 20.0 * std::cos(angle)));
      if (i == 0) {
        estimate.push_back(pose);
        graph.AddNode(KeyframeId{0}, pose);
      } else {
        const SE2 step = Disturbed(truth.back().Inverse() * pose, step_information, 1.0, &random);
        estimate.push_back(estimate.back() * step);
        graph.AddNode(KeyframeId{i}, estimate.back());
        graph.AddConstraint({KeyframeId{i - 1}, KeyframeId{i}, step, step_information, Kind::kSubmap});
      }
      truth.push_back(pose);
    }
    for (int begun = 0; begun < 2 * kPerRound; begun += 10) {
      const SubmapId submap{begun / 10};
      graph.AddNode(submap, estimate[static_cast<size_t>(begun)]);
      graph.AddConstraint({submap, KeyframeId{begun}, SE2(), 1e8 * Eigen::Matrix3d::Identity(), Kind::kSubmap});
      for (int i = 0; i < 2 * kPerRound; ++i) {
        const SE2 T_submap_keyframe = truth[static_cast<size_t>(begun)].Inverse() * truth[static_cast<size_t>(i)];
        if (std::abs(i - begun) < kPerRound / 2 || T_submap_keyframe.translation().norm() > 8.0) continue;
        const Eigen::Matrix3d information = RandomInformation(&random, 0.01, 0.002);
        SE2 measured = Disturbed(T_submap_keyframe, information, optimism, &random);
        if (random.Uniform() < wrong_share) {
          // The neighbouring tree or row.
          measured = measured * (random.Uniform() < 0.5 ? SE2(1.5, 0.0, 0.0) : SE2(0.0, 3.5, 0.02));
          wrong.emplace(submap.value, i);
        }
        graph.AddConstraint({submap, KeyframeId{i}, measured, information, Kind::kLoop});
        ++num_loops;
      }
    }
  }

  double LargestLoopError() const {
    double largest = 0.0;
    for (const Constraint& c : graph.constraints()) {
      if (c.kind != Kind::kLoop || wrong.count({c.from.value, c.to.value}) > 0) continue;
      largest = std::max(largest, WeightedError(graph, c));
    }
    return largest;
  }
};

TEST(PoseGraph, RightLoopsRemoveADriftOfHundredsOfStandardDeviations) {
  double largest_drift = 0.0;
  for (uint64_t seed = 0; seed < 5; ++seed) {
    Orchard orchard(1.0, 0.0, seed);
    ASSERT_GT(orchard.num_loops, 200u);
    largest_drift = std::max(largest_drift, Rmse(orchard.graph, orchard.truth));
    EXPECT_GT(orchard.LargestLoopError(), 100.0);
    const PoseGraphSummary summary = orchard.graph.Optimize({}, 1);
    EXPECT_TRUE(summary.dropped_loops.empty()) << seed << ": " << summary.dropped_loops.size();
    EXPECT_LT(orchard.LargestLoopError(), 10.0);
    // Honest claims: the weighted squared errors are chi-square, 3 for each constraint less the unknowns.
    const double freedom = 3.0 * static_cast<double>(orchard.graph.constraints().size()) -
                           3.0 * static_cast<double>(orchard.graph.poses().size() - 1);
    EXPECT_NEAR(ChiSquare(orchard.graph), freedom, 5.0 * std::sqrt(2.0 * freedom)) << seed;
  }
  EXPECT_GT(largest_drift, 1.0);
}

TEST(PoseGraph, LoopsThatErrByThriceTheirClaimAreKept) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    Orchard orchard(3.0, 0.0, seed);
    const PoseGraphSummary summary = orchard.graph.Optimize({}, 1);
    // The gate leaves out the one in a hundred that errs most.
    EXPECT_LE(summary.dropped_loops.size(), orchard.num_loops / 30) << seed;
    EXPECT_EQ(orchard.graph.constraints().size(), 199u + 20u + orchard.num_loops - summary.dropped_loops.size());
  }
}

TEST(PoseGraph, LoopsToTheNeighbouringTreeAreDroppedInSpiteOfDrift) {
  for (const double share : {0.1, 0.3}) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      Orchard clean(2.0, 0.0, seed);
      clean.graph.Optimize({}, 1);
      Orchard orchard(2.0, share, seed);
      ASSERT_GT(orchard.wrong.size(), 20u);
      const PoseGraphSummary summary = orchard.graph.Optimize({}, 1);
      EXPECT_EQ(PairsOf(summary.dropped_loops), orchard.wrong) << share << " " << seed;
      EXPECT_LT(Rmse(orchard.graph, KeyframePoses(clean.graph)), 0.1) << share << " " << seed;
    }
  }
}

TEST(PoseGraph, OneRightLoopIsEnough) {
  // A chain whose claimed uncertainty allows for its drift of 2 m, and one loop that is sure to 5 mm.
  PoseGraph graph;
  for (int i = 0; i <= 100; ++i) {
    graph.AddNode(KeyframeId{i}, SE2(i, 0.02 * i, 0.0));
    if (i == 0) continue;
    graph.AddConstraint({KeyframeId{i - 1}, KeyframeId{i}, SE2(1.0, 0.02, 0.0), Diagonal(0.15, 0.002), Kind::kMotion});
  }
  graph.AddConstraint({KeyframeId{0}, KeyframeId{100}, SE2(100.0, 0.0, 0.0), Diagonal(0.005, 0.01), Kind::kLoop});
  const PoseGraphSummary summary = graph.Optimize({}, 1);
  EXPECT_TRUE(summary.dropped_loops.empty());
  EXPECT_LT((graph.Pose(KeyframeId{100}).translation() - Eigen::Vector2d(100.0, 0.0)).norm(), 0.02);
  EXPECT_LT((graph.Pose(KeyframeId{50}).translation() - Eigen::Vector2d(50.0, 0.0)).norm(), 0.6);
}

TEST(PoseGraph, OneWrongLoopIsDroppedAndLeavesNoTrace) {
  Orchard with(1.0, 0.0, 5);
  Orchard without(1.0, 0.0, 5);
  const Constraint wrong{SubmapId{1}, KeyframeId{150}, SE2(1.0, 1.0, 1.0), Diagonal(0.01, 0.002), Kind::kLoop};
  with.graph.AddConstraint(wrong);
  const PoseGraphSummary summary = with.graph.Optimize({}, 1);
  without.graph.Optimize({}, 1);
  ASSERT_EQ(summary.dropped_loops.size(), 1u);
  EXPECT_TRUE(summary.dropped_loops[0].from == wrong.from && summary.dropped_loops[0].to == wrong.to);
  for (const auto& [id, pose] : without.graph.poses()) EXPECT_TRUE(with.graph.Pose(id).IsApprox(pose, 1e-4)) << id;
}

TEST(PoseGraph, AnyNumberOfThreadsGivesTheSameBits) {
  for (const double share : {0.0, 0.2}) {
    Orchard one(2.0, share, 9);
    const PoseGraphSummary summary_one = one.graph.Optimize({}, 1);
    for (const int num_threads : {1, 2, 5}) {
      Orchard many(2.0, share, 9);
      const PoseGraphSummary summary = many.graph.Optimize({}, num_threads);
      for (const auto& [id, pose] : one.graph.poses()) ASSERT_EQ(many.graph.Pose(id).vector(), pose.vector()) << id;
      EXPECT_EQ(summary.final_cost, summary_one.final_cost);
      EXPECT_EQ(summary.iterations, summary_one.iterations);
      EXPECT_EQ(PairsOf(summary.dropped_loops), PairsOf(summary_one.dropped_loops));
    }
  }
}

TEST(PoseGraphDeathTest, MisuseIsNamed) {
  PoseGraph graph;
  graph.AddNode(KeyframeId{1}, SE2());
  graph.AddNode(KeyframeId{2}, SE2());
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  EXPECT_DEATH(graph.AddNode(KeyframeId{1}, SE2()), "keyframe 1 is in the graph already");
  EXPECT_DEATH(graph.AddConstraint({KeyframeId{1}, SubmapId{3}, SE2(), unit, Kind::kLoop}), "submap 3");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DEATH(graph.AddConstraint({KeyframeId{1}, KeyframeId{2}, SE2(), nan * unit, Kind::kLoop}), "is not finite");
}

// The Manhattan world (Olson): 3500 poses, 3499 odometry edges, and 2099 loops.
class Manhattan : public testing::Test {
 protected:
  void SetUp() override {
    const char* const variable = std::getenv("ARBORSLAM_DATA");
    const std::filesystem::path data =
        variable != nullptr ? variable : std::string(ARBORSLAM_SOURCE_DIR) + "/../shared/data";
    const std::filesystem::path graph = data / "g2o" / "manhattan3500.g2o";
    const std::filesystem::path ground_truth = data / "g2o" / "manhattan3500_ground_truth.dat";
    if (!std::filesystem::exists(graph) || !std::filesystem::exists(ground_truth)) {
      GTEST_SKIP() << "needs " << graph << " and " << ground_truth << "; set ARBORSLAM_DATA";
    }
    graph_ = ReadG2o(graph.string());
    std::ifstream lines(ground_truth);
    double x = 0.0;
    double y = 0.0;
    double theta = 0.0;
    while (lines >> x >> y >> theta) truth_.emplace_back(x, y, theta);
    ASSERT_EQ(truth_.size(), graph_.vertices.size());
    for (const auto& [id, pose] : graph_.vertices) odometry_.push_back(pose);
  }

  PoseGraph Build(const std::vector<SE2>& initial, bool are_loops_certain = false) const {
    PoseGraph graph;
    for (size_t i = 0; i < initial.size(); ++i) graph.AddNode(KeyframeId{static_cast<int>(i)}, initial[i]);
    for (const PoseGraph2::Edge& edge : graph_.edges) {
      const Kind kind = edge.to == edge.from + 1 || are_loops_certain ? Kind::kSubmap : Kind::kLoop;
      graph.AddConstraint({KeyframeId{edge.from}, KeyframeId{edge.to}, edge.measurement, edge.information, kind});
    }
    return graph;
  }

  // Loops between poses that are far apart, with a tenth of the standard deviation of the others.
  std::multiset<Pair> AddWrongLoops(int count, PoseGraph* graph) const {
    Random random(11);
    std::multiset<Pair> wrong;
    while (static_cast<int>(wrong.size()) < count) {
      const auto from = static_cast<size_t>(random.Uniform(0.0, 3500.0));
      const auto to = static_cast<size_t>(random.Uniform(0.0, 3500.0));
      if ((truth_[from].translation() - truth_[to].translation()).norm() < 5.0) continue;
      wrong.emplace(static_cast<int>(from), static_cast<int>(to));
      graph->AddConstraint({KeyframeId{static_cast<int>(from)}, KeyframeId{static_cast<int>(to)},
                            RandomPose(&random, 2.0), 100.0 * graph_.edges[0].information, Kind::kLoop});
    }
    return wrong;
  }

  PoseGraph2 graph_;
  std::vector<SE2> truth_;
  std::vector<SE2> odometry_;
};

TEST_F(Manhattan, ConvergesFromOdometryToTheOptimumNextToTheTruth) {
  PoseGraph from_odometry = Build(odometry_);
  const PoseGraphSummary summary = from_odometry.Optimize({}, 1);
  PoseGraph from_truth = Build(truth_);
  const PoseGraphSummary reference = from_truth.Optimize({}, 1);
  EXPECT_TRUE(summary.dropped_loops.empty());
  EXPECT_TRUE(reference.dropped_loops.empty());
  EXPECT_NEAR(summary.final_cost, reference.final_cost, 1e-5 * reference.final_cost);
  // Plain least squares of all edges, whose optimum the robust one must not miss by more than its loss costs.
  PoseGraph plain = Build(truth_, true);
  const double chi_square = 2.0 * plain.Optimize({}, 1).final_cost;
  EXPECT_NEAR(chi_square, 146.08, 0.01);
  EXPECT_NEAR(ChiSquare(plain), chi_square, 1e-6);
  EXPECT_NEAR(ChiSquare(from_odometry), chi_square, 1e-3 * chi_square);
  EXPECT_LT(Rmse(from_odometry, KeyframePoses(plain)), 0.05);
  EXPECT_LT(Rmse(from_odometry, KeyframePoses(from_truth)), 0.05);
}

TEST_F(Manhattan, WrongLoopsDoNotBendIt) {
  PoseGraph clean = Build(odometry_);
  clean.Optimize({}, 1);
  const double clean_error = Rmse(clean, truth_);
  // 1; 10 % and 30 % of the number of right ones.
  for (const int count : {1, 210, 630}) {
    PoseGraph graph = Build(odometry_);
    const std::multiset<Pair> wrong = AddWrongLoops(count, &graph);
    const PoseGraphSummary summary = graph.Optimize({}, 2);
    EXPECT_EQ(PairsOf(summary.dropped_loops), wrong) << count;
    EXPECT_LT(Rmse(graph, truth_), 1.1 * clean_error) << count;
    EXPECT_LT(Rmse(graph, KeyframePoses(clean)), 0.1 * clean_error) << count;
  }
}

}  // namespace
}  // namespace arborslam
