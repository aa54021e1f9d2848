#include "core/io/vertex_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/geometry/angles.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The poses of vertices 0 and 1, however they are written.
void ExpectTwoPoses(const std::string& name, const std::string& text) {
  const TempFolder folder;
  const Trajectory poses = ToPlanar(ReadVertexPoses(folder.Write(name, text)));
  ASSERT_EQ(poses.size(), 2u) << text;
  EXPECT_EQ(poses[0].stamp, 0.0) << text;
  EXPECT_TRUE(poses[0].pose.IsApprox(SE2(1.0, 2.0, 0.0))) << text;
  EXPECT_EQ(poses[1].stamp, 1.0) << text;
  EXPECT_TRUE(poses[1].pose.IsApprox(SE2(-3.0, 4.0, 0.5 * kPi))) << text;
}

std::string ErrorOf(const std::string& text) {
  const TempFolder folder;
  const std::string path = folder.Write("truth.dat", text);
  return UserErrorOf([&] { ReadVertexPoses(path); });
}

TEST(VertexPoses, EveryFormatIsToldFromTheContent) {
  const std::string quarter = "1.5707963267948966";
  ExpectTwoPoses("a.dat", "# x y theta\n1 2 0\n-3 4 " + quarter + "\n");
  ExpectTwoPoses("b.dat", "1 -3 4 " + quarter + "\n0 1 2 0\n");
  ExpectTwoPoses("c.g2o", "VERTEX_SE2 0 1 2 0\nVERTEX_SE2 1 -3 4 " + quarter + "\n");
  ExpectTwoPoses("d.tum", "0 1 2 0 0 0 0 1\n1 -3 4 0 0 0 0.70710678118654752 0.70710678118654752\n");
}

TEST(VertexPoses, DamagedLinesAreNamed) {
  EXPECT_THAT(ErrorOf("0 1 2 0\n1 3 4\n"), AllOf(HasSubstr("truth.dat, line 2"), HasSubstr("id x y theta")));
  EXPECT_THAT(ErrorOf("1 2 0\n1 3 4 0\n"), AllOf(HasSubstr("line 2"), HasSubstr("x y theta")));
  EXPECT_THAT(ErrorOf("1 2\n"), AllOf(HasSubstr("line 1"), HasSubstr("2 columns")));
  EXPECT_THAT(ErrorOf("5 1 2 0\n5 1 2 0\n"), AllOf(HasSubstr("line 2"), HasSubstr("vertex 5 a second time")));
  EXPECT_THAT(ErrorOf("0.5 1 2 0\n"), HasSubstr("id '0.5' is not an integer"));
  EXPECT_THAT(ErrorOf("0 1 nan 0\n"), HasSubstr("y 'nan' is not finite"));
  EXPECT_THAT(ErrorOf("# nothing\n"), HasSubstr("holds no poses"));
  EXPECT_THAT(UserErrorOf([] { ReadVertexPoses("/nowhere/truth.dat"); }), HasSubstr("does not exist"));
}

}  // namespace
}  // namespace arborslam
