#include "core/evaluation/relations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/se2.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Trajectory3 Planar(const std::vector<std::pair<double, SE2>>& poses) {
  Trajectory trajectory;
  for (const auto& [stamp, pose] : poses) trajectory.push_back({stamp, pose});
  return ToTrajectory3(trajectory);
}

TEST(RelationsTest, ReadsTheFormatOfKuemmerle) {
  const TempFolder folder;
  const std::vector<Relation> relations = ReadRelations(
      folder.Write("a.relations", "# comment\n1.5 2.5 1 2 3 0 0 1.5707963267948966\n2 1 0 0 0 0.1 0.2 0.3\n"));
  ASSERT_EQ(relations.size(), 2u);
  EXPECT_EQ(relations[0].from_stamp, 1.5);
  EXPECT_EQ(relations[0].to_stamp, 2.5);
  EXPECT_TRUE((relations[0].T_from_to * Eigen::Vector3d(1.0, 0.0, 0.0)).isApprox(Eigen::Vector3d(1.0, 3.0, 3.0)));
  // Yaw, pitch, roll about the turned axes: the columns of the rotation, by hand.
  const Eigen::Matrix3d R = relations[1].T_from_to.linear();
  EXPECT_NEAR(R(2, 0), -std::sin(0.2), 1e-12);
  EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), 0.3, 1e-12);
  EXPECT_NEAR(std::atan2(R(2, 1), R(2, 2)), 0.1, 1e-12);
}

// Errors of 0.3 m and of 0.4 m across and 0.1 rad: mean 0.35, standard deviation 0.05, by hand.
TEST(RelationsTest, MeanAndStandardDeviation) {
  const TempFolder folder;
  const std::vector<Relation> relations =
      ReadRelations(folder.Write("a.relations", "0 1 1 0 0 0 0 0\n1 2 1 0 0 0 0 0.5\n7 8 1 1 1 0 0 0\n"));
  const SE2 a(3.0, -2.0, 1.0);
  const SE2 b = a * SE2(1.3, 0.0, 0.0);
  const SE2 c = b * SE2(1.0, 0.4, 0.6);
  const RelationMetrics metrics = EvaluateRelations(Planar({{0.0, a}, {1.0, b}, {2.0, c}}), relations, 0.01, "here");
  EXPECT_EQ(metrics.num_matched, 2u);
  EXPECT_EQ(metrics.num_relations, 3u);
  EXPECT_NEAR(metrics.translation_mean, 0.35, 1e-9);
  EXPECT_NEAR(metrics.translation_sd, 0.05, 1e-9);
  EXPECT_NEAR(metrics.translation_max, 0.4, 1e-9);
  EXPECT_NEAR(metrics.rotation_mean, 0.05, 1e-9);
  EXPECT_NEAR(metrics.rotation_sd, 0.05, 1e-9);
  EXPECT_NEAR(metrics.rotation_max, 0.1, 1e-9);
}

TEST(RelationsTest, WhereTheTrajectoryLiesDoesNotMatter) {
  Relation relation;
  relation.from_stamp = 2.0;
  relation.to_stamp = 0.0;  // Backwards in time.
  const SE2 step(1.0, 2.0, 0.7);
  relation.T_from_to.translation() << step.x(), step.y(), 0.0;
  relation.T_from_to.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (const SE2& origin : {SE2(), SE2(100.0, -50.0, 3.0)}) {
    const RelationMetrics metrics =
        EvaluateRelations(Planar({{0.0, origin * step}, {2.0, origin}}), {relation}, 0.01, "here");
    EXPECT_NEAR(metrics.translation_mean, 0.0, 1e-9);
    EXPECT_NEAR(metrics.rotation_mean, 0.0, 1e-7);
  }
}

TEST(RelationsTest, TheNearestPoseWithinTheTimeAllowed) {
  Relation relation;
  relation.from_stamp = 0.004;
  relation.to_stamp = 1.02;
  relation.T_from_to.translation().x() = 1.0;
  const Trajectory3 estimate = Planar({{0.0, SE2()}, {0.1, SE2(5.0, 0.0, 0.0)}, {1.0, SE2(1.0, 0.0, 0.0)}});
  EXPECT_NEAR(EvaluateRelations(estimate, {relation}, 0.05, "here").translation_mean, 0.0, 1e-12);
  EXPECT_THAT(UserErrorOf([&] { EvaluateRelations(estimate, {relation}, 0.01, "here"); }),
              AllOf(HasSubstr("here: none of the 1 relations"), HasSubstr("3 poses")));
  EXPECT_THAT(UserErrorOf([&] { EvaluateRelations(Trajectory3(), {relation}, 0.01, "here"); }), HasSubstr("none of"));
}

TEST(RelationsTest, NamesWhatIsWrong) {
  const TempFolder folder;
  const auto error = [&folder](const std::string& text) {
    return UserErrorOf([&] { ReadRelations(folder.Write("a.relations", text)); });
  };
  EXPECT_THAT(error("1 2 0 0 0 0 0 0\n1 2 3\n"), AllOf(HasSubstr("line 2"), HasSubstr("3 columns instead of 8")));
  EXPECT_THAT(error("1 2 0 0 0 0 0 nan\n"), AllOf(HasSubstr("yaw"), HasSubstr("'nan'")));
  EXPECT_THAT(error("1 2 0 1e10 0 0 0 0\n"), AllOf(HasSubstr("y is beyond"), HasSubstr("line 1")));
  EXPECT_THAT(error("# nothing\n"), HasSubstr("holds no relations"));
}

}  // namespace
}  // namespace arborslam
