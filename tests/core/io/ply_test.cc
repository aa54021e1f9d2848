#include "core/io/ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "core/simulation/random.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::HasSubstr;

struct Ply {
  std::vector<std::string> header;  // Its lines.
  std::string body;
};

Ply ReadPly(const std::string& path) {
  const std::string contents = ReadWhole(path);
  const std::string end = "end_header\n";
  const size_t header_size = contents.find(end) + end.size();
  Ply ply;
  std::istringstream header(contents.substr(0, header_size));
  for (std::string line; std::getline(header, line);) ply.header.push_back(line);
  ply.body = contents.substr(header_size);
  return ply;
}

// Of a test machine that is little-endian, as all that we know of are.
Eigen::Vector3f PointAt(const std::string& body, size_t offset) {
  Eigen::Vector3f point;
  std::memcpy(point.data(), body.data() + offset, sizeof(float) * 3);
  return point;
}

TEST(Ply, PointsAndColoursReadBackExactly) {
  Random random(4);
  std::vector<Eigen::Vector3f> points;
  std::vector<Colour> colours;
  for (int i = 0; i < 1000; ++i) {
    points.push_back(Eigen::Vector3d(random.Gaussian(), 1e5 * random.Gaussian(), random.Gaussian()).cast<float>());
    colours.push_back(Viridis(random.Uniform()));
  }
  const TempFolder folder;
  WritePly(folder.File("cloud.ply"), points, colours);
  const Ply ply = ReadPly(folder.File("cloud.ply"));
  EXPECT_THAT(ply.header,
              testing::ElementsAre("ply", "format binary_little_endian 1.0", "element vertex 1000", "property float x",
                                   "property float y", "property float z", "property uchar red", "property uchar green",
                                   "property uchar blue", "end_header"));
  ASSERT_EQ(ply.body.size(), 15000u);
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(PointAt(ply.body, 15 * i), points[i]);
    Colour colour;
    std::memcpy(colour.data(), ply.body.data() + 15 * i + 12, 3);
    ASSERT_EQ(colour, colours[i]);
  }
}

TEST(Ply, WithoutColours) {
  const TempFolder folder;
  WritePly(folder.File("cloud.ply"), {{1.0f, -2.0f, 0.5f}}, {});
  const Ply ply = ReadPly(folder.File("cloud.ply"));
  EXPECT_THAT(ply.header, testing::Contains("element vertex 1"));
  EXPECT_THAT(ply.header, testing::Not(testing::Contains(HasSubstr("uchar"))));
  // 1.0f is 0x3F800000, the lowest byte first.
  EXPECT_EQ(ply.body.substr(0, 4), std::string("\x00\x00\x80\x3F", 4));
  ASSERT_EQ(ply.body.size(), 12u);
  EXPECT_EQ(PointAt(ply.body, 0), Eigen::Vector3f(1.0f, -2.0f, 0.5f));
}

TEST(Ply, AnEmptyCloudIsAWholeFile) {
  const TempFolder folder;
  WritePly(folder.File("cloud.ply"), {}, {});
  const Ply ply = ReadPly(folder.File("cloud.ply"));
  EXPECT_THAT(ply.header, testing::Contains("element vertex 0"));
  EXPECT_EQ(ply.header.back(), "end_header");
  EXPECT_TRUE(ply.body.empty());
}

TEST(Ply, AFileThatCannotBeWrittenIsAnError) {
  const TempFolder folder;
  const std::string path = folder.Write("file", "") + "/cloud.ply";
  EXPECT_THAT(UserErrorOf([&] { WritePly(path, {}, {}); }), HasSubstr(path));
}

TEST(PlyDeathTest, RefusesPointsThatAreNotFiniteAndColoursThatDoNotBelong) {
  const TempFolder folder;
  const std::string path = folder.File("cloud.ply");
  EXPECT_DEATH(WritePly(path, {{0.0f, std::numeric_limits<float>::quiet_NaN(), 0.0f}}, {}), "point 0");
  EXPECT_DEATH(WritePly(path, {{0.0f, 0.0f, 0.0f}}, {Colour(), Colour()}), "2 colours, 1 points");
}

}  // namespace
}  // namespace arborslam
