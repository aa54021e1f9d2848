#include "core/io/g2o.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <set>
#include <string>

#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr char kTwoVertices[] = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";

std::string ErrorOf(const std::string& text) {
  const TempFolder folder;
  const std::string path = folder.Write("a.g2o", text);
  return UserErrorOf([&] { ReadG2o(path); });
}

TEST(G2o, ReadsVerticesEdgesAndTheInformationsUpperTriangle) {
  const TempFolder folder;
  const PoseGraph2 graph = ReadG2o(folder.Write(
      "a.g2o",
      "# a comment\nEDGE_SE2 0 7 1 2 0.5 10 1 2 11 3 12\nVERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_SE2 7 1.5 -2 0.25\n"));
  ASSERT_EQ(graph.vertices.size(), 2u);
  EXPECT_TRUE(graph.vertices.at(7).IsApprox(SE2(1.5, -2.0, 0.25)));
  ASSERT_EQ(graph.edges.size(), 1u);
  EXPECT_EQ(graph.edges[0].from, 0);
  EXPECT_EQ(graph.edges[0].to, 7);
  EXPECT_TRUE(graph.edges[0].measurement.IsApprox(SE2(1.0, 2.0, 0.5)));
  const Eigen::Matrix3d expected = (Eigen::Matrix3d() << 10, 1, 2, 1, 11, 3, 2, 3, 12).finished();
  EXPECT_EQ(graph.edges[0].information, expected);
  EXPECT_EQ(graph.fixed, std::set<int>{0});
}

TEST(G2o, IsToldByItsNameOrItsFirstRecord) {
  const TempFolder folder;
  EXPECT_TRUE(IsG2oFile(folder.Write("a", "# poses\n\n  EDGE_SE2 0 5\n")));
  EXPECT_TRUE(IsG2oFile(folder.Write("b", "VERTEX_SE3:QUAT 0\n")));
  EXPECT_TRUE(IsG2oFile(folder.Write("c", "FIX 0\nVERTEX_SE2")));
  EXPECT_TRUE(IsG2oFile(folder.Write("d.g2o", "1 2 3\n")));
  EXPECT_FALSE(IsG2oFile(folder.Write("e", "# VERTEX_SE2\n0 0 0 0\n")));
  EXPECT_FALSE(IsG2oFile(folder.Write("f", std::string("PK\3\4\0\0", 6))));
  EXPECT_FALSE(IsG2oFile(folder.Write("g", "\n")));
  EXPECT_FALSE(IsG2oFile(folder.Write("h", "")));
  EXPECT_FALSE(IsG2oFile(folder.path()));
  EXPECT_FALSE(IsG2oFile("/nowhere/a.g2o"));
}

TEST(G2o, GraphsReadBackExactly) {
  const TempFolder folder;
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  PoseGraph2 written;
  for (int id = 0; id < 50; ++id) written.vertices[3 * id] = SE2(normal(random), normal(random), normal(random));
  for (int i = 0; i + 1 < 50; ++i) {
    const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return normal(random); });
    const Eigen::Matrix3d information = root * root.transpose() + Eigen::Matrix3d::Identity();
    written.edges.push_back({3 * i, 3 * i + 3, SE2(normal(random), normal(random), normal(random)),
                             information.selfadjointView<Eigen::Upper>()});
  }
  written.fixed = {3, 9};
  WriteG2o(folder.File("a.g2o"), written);
  const PoseGraph2 read = ReadG2o(folder.File("a.g2o"));
  ASSERT_EQ(read.vertices.size(), written.vertices.size());
  for (const auto& [id, pose] : written.vertices) EXPECT_EQ(read.vertices.at(id).vector(), pose.vector()) << id;
  EXPECT_EQ(read.fixed, written.fixed);
  ASSERT_EQ(read.edges.size(), written.edges.size());
  for (size_t i = 0; i < read.edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].from, written.edges[i].from);
    EXPECT_EQ(read.edges[i].to, written.edges[i].to);
    EXPECT_EQ(read.edges[i].measurement.vector(), written.edges[i].measurement.vector());
    EXPECT_EQ(read.edges[i].information, written.edges[i].information);
  }
}

TEST(G2o, DamagedRecordsAreNamedByLine) {
  const std::string two = kTwoVertices;
  EXPECT_THAT(ErrorOf(two + "EDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n"),
              AllOf(HasSubstr("a.g2o, line 3"), HasSubstr("vertex 5")));
  EXPECT_THAT(ErrorOf("EDGE_SE2 4 1 1 0 0 1 0 0 1 0 1\n" + two), AllOf(HasSubstr("line 1"), HasSubstr("vertex 4")));
  EXPECT_THAT(ErrorOf(two + "\nVERTEX_SE2 1 0 0 0\n"), AllOf(HasSubstr("line 4"), HasSubstr("vertex 1 a second time")));
  EXPECT_THAT(ErrorOf(two + "EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n"), AllOf(HasSubstr("line 3"), HasSubstr("itself")));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 nan 0\n"), AllOf(HasSubstr("line 1"), HasSubstr("y 'nan' is not finite")));
  EXPECT_THAT(ErrorOf(two + "EDGE_SE2 0 1 1 0 0 1 0 inf 1 0 1\n"), HasSubstr("I13 'inf'"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0.5 0 0 0\n"), HasSubstr("id '0.5' is not an integer"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 99999999999 0 0 0\n"), HasSubstr("'99999999999'"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 -1 0 0 0\n"), AllOf(HasSubstr("line 1"), HasSubstr("vertex id -1")));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 2e9 0\n"), AllOf(HasSubstr("line 1"), HasSubstr("y '2e9' is beyond 1e+09")));
  EXPECT_THAT(ErrorOf(two + "EDGE_SE2 0 1 1 0 0 1e200 0 0 1 0 1\n"), HasSubstr("I11 '1e200' is beyond 1e+15"));
  EXPECT_THAT(ErrorOf("FIX 0 7\n" + two), AllOf(HasSubstr("line 1"), HasSubstr("fixes vertex 7")));
  EXPECT_THAT(ErrorOf(two + "FIX\n"), AllOf(HasSubstr("line 3"), HasSubstr("FIX id")));
  EXPECT_THAT(ErrorOf(two + "FIX zero\n"), HasSubstr("id 'zero' is not an integer"));
  EXPECT_THAT(ErrorOf("VERTEX_SE2 0 0 0\n"), AllOf(HasSubstr("4 columns"), HasSubstr("VERTEX_SE2 id x y theta")));
  EXPECT_THAT(ErrorOf(two + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n"), HasSubstr("11 columns"));
  EXPECT_THAT(ErrorOf(two + "EDGE_SE3:QUAT 0 1\n"),
              AllOf(HasSubstr("line 3"), HasSubstr("'EDGE_SE3:QUAT'"), HasSubstr("VERTEX_SE2, EDGE_SE2, FIX")));
}

TEST(G2o, TheInformationMustBePositiveDefinite) {
  const std::string edge = std::string(kTwoVertices) + "EDGE_SE2 0 1 1 0 0 ";
  EXPECT_THAT(ErrorOf(edge + "0 0 0 0 0 0\n"), AllOf(HasSubstr("line 3"), HasSubstr("positive definite")));
  EXPECT_THAT(ErrorOf(edge + "1 0 0 -1 0 1\n"), HasSubstr("positive definite"));
  EXPECT_THAT(ErrorOf(edge + "1 2 0 1 0 1\n"), HasSubstr("positive definite"));
}

TEST(G2o, FilesWithoutAGraphAreErrors) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("is empty"));
  EXPECT_THAT(ErrorOf("# nothing\n"), HasSubstr("no VERTEX_SE2"));
  EXPECT_THAT(UserErrorOf([] { ReadG2o("/nowhere/a.g2o"); }), HasSubstr("does not exist"));
}

TEST(G2o, AFileThatCannotBeWrittenIsAnError) {
  const TempFolder folder;
  const std::string path = folder.Write("file", "") + "/a.g2o";
  EXPECT_THAT(UserErrorOf([&] { WriteG2o(path, {}); }), HasSubstr(path));
}

TEST(G2o, ReadsThePublicBenchmarks) {
  const std::tuple<std::string, size_t, size_t> graphs[] = {{"manhattan3500.g2o", 3500, 5598},
                                                            {"intel.g2o", 1728, 2512}};
  for (const auto& [name, num_vertices, num_edges] : graphs) {
    const std::string path = DataFolder() + "/g2o/" + name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set ARBORSLAM_DATA";
    const PoseGraph2 graph = ReadG2o(path);
    EXPECT_EQ(graph.vertices.size(), num_vertices);
    EXPECT_EQ(graph.edges.size(), num_edges);
  }
}

}  // namespace
}  // namespace arborslam
