// Runs the program itself on pose graphs.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "core/io/g2o.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/orchard_graph.h"
#include "tests/apps/program_test.h"

namespace arborslam {
namespace {

class GraphRunTest : public ProgramTest {
 protected:
  int Run(const std::string& arguments) const { return ProgramTest::Run("arborslam_offline", arguments).exit_code; }

  std::string Errors() const { return ReadFile(Path(".stderr")); }
};

TEST_F(GraphRunTest, AGraphIsSmoothedAndHeldAgainstTheTruth) {
  OrchardGraphOptions options;
  options.num_keyframes = 600;
  const OrchardGraph run = SimulateOrchardGraph(options);
  WriteG2o(Path("run.g2o").string(), run.graph);
  std::string truth;
  for (size_t i = 0; i < run.truth.size(); ++i) {
    truth += std::to_string(i) + " " + std::to_string(run.truth[i].x()) + " " + std::to_string(run.truth[i].y()) + " " +
             std::to_string(run.truth[i].theta()) + "\n";
  }
  Write("truth.dat", truth);
  fs::create_directories(Path("out"));
  Write("out/map.png", "of an earlier run");
  ASSERT_EQ(Run("--input run.g2o --output out --ground_truth truth.dat --threads 1"), 0) << Errors();
  std::set<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(Path("out"))) files.insert(entry.path().filename());
  EXPECT_EQ(files, (std::set<std::string>{"effective_config.yaml", "graph.g2o", "graph.png", "report.html",
                                          "summary.json", "trajectory.tum"}));

  const nlohmann::json summary = nlohmann::json::parse(ReadFile(Path("out/summary.json")));
  EXPECT_EQ(summary["graph"]["vertices"], run.graph.vertices.size());
  EXPECT_EQ(summary["graph"]["edges"], run.graph.edges.size());
  EXPECT_EQ(summary["optimization"]["loops_dropped"], 0);
  EXPECT_LT(summary["optimization"]["final_chi2"], summary["optimization"]["initial_chi2"]);
  EXPECT_LT(summary["errors"]["trajectory"]["ate_se2_rmse_m"], 0.05);
  EXPECT_GT(summary["errors"]["as_given"]["ate_se2_rmse_m"], summary["errors"]["trajectory"]["ate_se2_rmse_m"]);

  const PoseGraph2 smoothed = ReadG2o(Path("out/graph.g2o").string());
  const Trajectory3 trajectory = ReadTrajectory(Path("out/trajectory.tum").string());
  ASSERT_EQ(trajectory.poses.size(), run.graph.vertices.size());
  EXPECT_EQ(trajectory.poses[599].stamp, 599.0);
  EXPECT_NEAR(trajectory.poses[599].position.x(), smoothed.vertices.at(599).x(), 1e-8);
  EXPECT_NE(ReadFile(Path("out/report.html")).find("data:image/png;base64,"), std::string::npos);
  // What was smoothed is at its optimum.
  ASSERT_EQ(Run("--input out/graph.g2o --output again --threads 2 --quiet"), 0) << Errors();
  const nlohmann::json again = nlohmann::json::parse(ReadFile(Path("again/summary.json")));
  EXPECT_NEAR(again["optimization"]["initial_chi2"], summary["optimization"]["final_chi2"], 1e-3);
}

TEST_F(GraphRunTest, PartsAreToldToTheUser) {
  Write("a.g2o", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 5 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(Run("--input a.g2o --output out"), 0);
  EXPECT_NE(Errors().find("in 2 parts that no edge joins"), std::string::npos) << Errors();
  EXPECT_NE(Errors().find("(0, 2)"), std::string::npos) << Errors();
}

TEST_F(GraphRunTest, WhatCannotBeUsedIsOneLineAndLeavesNothing) {
  const std::pair<std::string, std::string> cases[] = {
      {"VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n", "line 2: joins vertex 5"},
      {"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0\n", "line 2: has 4 columns instead of 5"},
      {"VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "VERTEX_SE3:QUAT"},
      {"", "is empty"}};
  for (const auto& [contents, message] : cases) {
    Write("a.g2o", contents);
    EXPECT_EQ(Run("--input a.g2o --output out"), 1);
    EXPECT_NE(Errors().find(message), std::string::npos) << Errors();
    EXPECT_FALSE(fs::exists(Path("out"))) << contents;
  }
  Write("a.g2o", "VERTEX_SE2 0 0 0 0\n");
  EXPECT_EQ(Run("--input a.g2o --output out --odometry_only"), 2);
  EXPECT_EQ(Run("--input a.g2o --output out --max_scans 3"), 2);
  EXPECT_FALSE(fs::exists(Path("out")));
}

}  // namespace
}  // namespace arborslam
