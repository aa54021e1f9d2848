#include "core/io/point_cloud_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/simulation/random.h"
#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// A sweep as a LIO-SAM file has it, made with PCL: x y z intensity ring time.
pcl::PCLPointCloud2 PclCloud(size_t num_points) {
  using Field = pcl::PCLPointField;
  pcl::PCLPointCloud2 cloud;
  const auto add_field = [&cloud](const std::string& name, uint8_t type, pcl::uindex_t size) {
    cloud.fields.emplace_back();
    cloud.fields.back().name = name;
    cloud.fields.back().offset = cloud.point_step;
    cloud.fields.back().datatype = type;
    cloud.fields.back().count = 1;
    cloud.point_step += size;
  };
  for (const char* name : {"x", "y", "z", "intensity"}) add_field(name, Field::FLOAT32, 4);
  add_field("ring", Field::UINT16, 2);
  add_field("time", Field::FLOAT32, 4);
  cloud.width = static_cast<pcl::uindex_t>(num_points);
  cloud.height = 1;
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.data.resize(cloud.row_step);
  Random random(7);
  for (size_t i = 0; i < num_points; ++i) {
    uint8_t* point = &cloud.data[i * cloud.point_step];
    for (size_t value = 0; value < 4; ++value) {
      const auto number = static_cast<float>(random.Uniform(-50.0, 50.0));
      std::memcpy(point + 4 * value, &number, 4);
    }
    const auto ring = static_cast<uint16_t>(i % 16);
    std::memcpy(point + 16, &ring, 2);
    const float time = 0.1f * static_cast<float>(i) / static_cast<float>(num_points);
    std::memcpy(point + 18, &time, 4);
  }
  return cloud;
}

float FloatAt(const pcl::PCLPointCloud2& cloud, size_t point, size_t offset) {
  float value = 0.0f;
  std::memcpy(&value, &cloud.data[point * cloud.point_step + offset], sizeof(value));
  return value;
}

void ExpectSamePoints(const PointCloudFile& file, const pcl::PCLPointCloud2& cloud, float tolerance) {
  ASSERT_EQ(file.sweep.points.size(), cloud.width);
  ASSERT_EQ(file.raw_times.size(), cloud.width);
  EXPECT_EQ(file.time_field, "time");
  for (size_t i = 0; i < cloud.width; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(file.sweep.points[i][axis], FloatAt(cloud, i, 4 * static_cast<size_t>(axis)), tolerance);
    }
    EXPECT_NEAR(file.raw_times[i], FloatAt(cloud, i, 18), tolerance);
  }
}

TEST(ReadPointCloudFile, ReadsWhatPclWrites) {
  const TempFolder folder;
  const pcl::PCLPointCloud2 cloud = PclCloud(500);
  const std::string path = folder.File("a.pcd");
  const Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  const Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  pcl::PCDWriter pcd;
  ASSERT_EQ(pcd.writeBinary(path, cloud, origin, orientation), 0);
  ExpectSamePoints(ReadPointCloudFile(path), cloud, 0.0f);
  ASSERT_EQ(pcd.writeBinaryCompressed(path, cloud, origin, orientation), 0);
  ExpectSamePoints(ReadPointCloudFile(path), cloud, 0.0f);
  ASSERT_EQ(pcd.writeASCII(path, cloud, origin, orientation, 8), 0);
  ExpectSamePoints(ReadPointCloudFile(path), cloud, 1e-5f);
  pcl::PLYWriter ply;
  ASSERT_EQ(ply.writeBinary(folder.File("a.ply"), cloud, origin, orientation, false), 0);
  ExpectSamePoints(ReadPointCloudFile(folder.File("a.ply")), cloud, 0.0f);
  ASSERT_EQ(ply.writeASCII(folder.File("a.ply"), cloud, origin, orientation, 8, false), 0);
  ExpectSamePoints(ReadPointCloudFile(folder.File("a.ply")), cloud, 1e-4f);
}

TEST(WritePcd, IsReadBackByUsAndByPcl) {
  const TempFolder folder;
  LidarSweep sweep;
  sweep.points = {{1, 2, 3}, {-4, 0, 1e-20f}, {7, 8, -9}};
  sweep.times = {0.0f, 0.05f, 0.1f};
  for (const bool has_times : {true, false}) {
    if (!has_times) sweep.times.clear();
    WritePcd(folder.File("a.pcd"), sweep);
    const PointCloudFile file = ReadPointCloudFile(folder.File("a.pcd"));
    EXPECT_EQ(file.sweep.points, sweep.points);
    EXPECT_THAT(file.raw_times, SizeIs(sweep.times.size()));
    for (size_t i = 0; i < sweep.times.size(); ++i) EXPECT_EQ(file.raw_times[i], sweep.times[i]);
    pcl::PCLPointCloud2 cloud;
    ASSERT_EQ(pcl::PCDReader().read(folder.File("a.pcd"), cloud), 0);
    EXPECT_EQ(cloud.width, 3u);
    EXPECT_EQ(FloatAt(cloud, 2, 8), -9.0f);
  }
  WritePcd(folder.File("none.pcd"), LidarSweep());
  EXPECT_THAT(ReadPointCloudFile(folder.File("none.pcd")).sweep.points, IsEmpty());
  EXPECT_THAT(UserErrorOf([&] { WritePcd(folder.File("no/a.pcd"), sweep); }), HasSubstr("cannot be written"));
}

TEST(ReadPointCloudFile, ReadsTextWithWhatPeopleWriteThere) {
  const TempFolder folder;
  const std::string path = folder.Write("a.pcd",
                                        "FIELDS ring x y z timestamp\nSIZE 1 4 4 4 8\nTYPE U F F F F\nPOINTS 6\n"
                                        "DATA ascii\r\n1 1.5 +2 -3e0 100.25\r\n\n  2\t4 5 6   100.5\n3 nan 1 1 100\n"
                                        "4 1 -inf 1 100\n5 0 0.0 -0 100\n6 1e60 1 1 100");
  const PointCloudFile file = ReadPointCloudFile(path);
  EXPECT_THAT(file.sweep.points, ElementsAre(Eigen::Vector3f(1.5f, 2, -3), Eigen::Vector3f(4, 5, 6)));
  EXPECT_EQ(file.sweep.num_dropped, 4u);
  EXPECT_THAT(file.raw_times, ElementsAre(100.25, 100.5));
  EXPECT_EQ(file.time_field, "timestamp");
}

TEST(ReadPointCloudFile, ReadsPlyWhateverStandsAroundItsVertices) {
  const TempFolder folder;
  const std::string text = folder.Write("a.ply",
                                        "ply\nformat ascii 1.0\nelement camera 1\nproperty float view_px\n"
                                        "property int viewportx\nelement vertex 2\nproperty uchar red\n"
                                        "property double x\nproperty float y\nproperty float z\nproperty uint t\n"
                                        "element face 1\nproperty list uchar int vertex_index\nend_header\n"
                                        "0.5 100000000\n255 1 2 3 0\n254 4 5 6 99000000\n3 0 1 1\n");
  const PointCloudFile file = ReadPointCloudFile(text);
  EXPECT_THAT(file.sweep.points, ElementsAre(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(4, 5, 6)));
  EXPECT_THAT(file.raw_times, ElementsAre(0.0, 99000000.0));
  EXPECT_EQ(file.time_field, "t");

  std::string body =
      RawValues<float>({1, 2, 3}) + RawValues<uint16_t>({5}) + RawValues<float>({4, 5, 6}) + RawValues<uint16_t>({258});
  const std::string vertices =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty ushort time\nend_header\n";
  const PointCloudFile little =
      ReadPointCloudFile(folder.Write("b.ply", "ply\nformat binary_little_endian 1.0\n" + vertices + body));
  EXPECT_EQ(little.sweep.points, file.sweep.points);
  EXPECT_THAT(little.raw_times, ElementsAre(5.0, 258.0));
  for (size_t begin : {0, 14}) {
    for (size_t value : {0, 4, 8}) std::reverse(&body[begin + value], &body[begin + value] + 4);
    std::reverse(&body[begin + 12], &body[begin + 12] + 2);
  }
  const PointCloudFile big =
      ReadPointCloudFile(folder.Write("c.ply", "ply\nformat binary_big_endian 1.0\n" + vertices + body));
  EXPECT_EQ(big.sweep.points, file.sweep.points);
  EXPECT_THAT(big.raw_times, ElementsAre(5.0, 258.0));
}

// A binary PCD of one point and a time of `type` and `size`, its bytes `time`.
std::vector<double> TimesOf(const std::string& type_and_size, const std::string& time) {
  const TempFolder folder;
  return ReadPointCloudFile(folder.Write("a.pcd", "FIELDS x y z offset_time\nSIZE 4 4 4 " + type_and_size.substr(1) +
                                                      "\nTYPE F F F " + type_and_size[0] + "\nPOINTS 1\nDATA binary\n" +
                                                      RawValues<float>({1, 2, 3}) + time))
      .raw_times;
}

TEST(ReadPointCloudFile, ReadsTimesOfAnyType) {
  EXPECT_THAT(TimesOf("F4", RawValues<float>({0.25f})), ElementsAre(0.25));
  EXPECT_THAT(TimesOf("F8", RawValues<double>({1664464000.25})), ElementsAre(1664464000.25));
  EXPECT_THAT(TimesOf("I1", RawValues<int8_t>({-5})), ElementsAre(-5.0));
  EXPECT_THAT(TimesOf("U1", RawValues<uint8_t>({250})), ElementsAre(250.0));
  EXPECT_THAT(TimesOf("I2", RawValues<int16_t>({-500})), ElementsAre(-500.0));
  EXPECT_THAT(TimesOf("U2", RawValues<uint16_t>({65000})), ElementsAre(65000.0));
  EXPECT_THAT(TimesOf("I4", RawValues<int32_t>({-100000})), ElementsAre(-100000.0));
  EXPECT_THAT(TimesOf("U4", RawValues<uint32_t>({4000000000})), ElementsAre(4000000000.0));
  EXPECT_THAT(TimesOf("I8", RawValues<int64_t>({-5000000000})), ElementsAre(-5000000000.0));
  EXPECT_THAT(TimesOf("U8", RawValues<uint64_t>({1664464000250000000})), ElementsAre(1664464000250000000.0));
}

std::string BinaryPcd(const std::vector<float>& values) {
  return "FIELDS x y z time\nPOINTS " + std::to_string(values.size() / 4) + "\nDATA binary\n" +
         RawValues<float>(values);
}

TEST(ReadPointCloudFile, DropsPointsThatAreNoneAndTheirTimes) {
  const TempFolder folder;
  const PointCloudFile file = ReadPointCloudFile(folder.Write(
      "a.pcd",
      BinaryPcd({1, 1, 1, 0.5f, kNaN, 1, 1, 0.6f, 0, 0, 0, 0.7f, 2, 2, 2, 0.8f, 3, 3, kInf, 0.9f, 4, 4, 4, 1})));
  EXPECT_THAT(file.sweep.points,
              ElementsAre(Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(2, 2, 2), Eigen::Vector3f(4, 4, 4)));
  EXPECT_THAT(file.raw_times, ElementsAre(0.5, 0.8f, 1.0));
  EXPECT_EQ(file.sweep.num_dropped, 3u);
}

TEST(ReadPointCloudFile, DropsPointsWithoutTimeUnlessMostHaveNone) {
  const TempFolder folder;
  const PointCloudFile some =
      ReadPointCloudFile(folder.Write("a.pcd", BinaryPcd({1, 1, 1, 0.5f, 2, 2, 2, kNaN, 3, 3, 3, -kInf, 4, 4, 4, 1})));
  EXPECT_THAT(some.sweep.points, ElementsAre(Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(4, 4, 4)));
  EXPECT_THAT(some.raw_times, ElementsAre(0.5, 1.0));
  EXPECT_EQ(some.sweep.num_dropped, 2u);
  const PointCloudFile most =
      ReadPointCloudFile(folder.Write("a.pcd", BinaryPcd({1, 1, 1, kNaN, 2, 2, 2, kNaN, 3, 3, 3, 0.5f})));
  EXPECT_THAT(most.sweep.points, SizeIs(3));
  EXPECT_THAT(most.raw_times, IsEmpty());
  EXPECT_EQ(most.time_field, "time");
  EXPECT_EQ(most.sweep.num_dropped, 0u);
}

TEST(ReadPointCloudFile, RefusesFilesWithoutUsableCoordinates) {
  const TempFolder folder;
  const auto error = [&](const std::string& header) {
    const std::string path = folder.Write("a.pcd", header + "POINTS 1\nDATA ascii\n1 2 3 4\n");
    return UserErrorOf([&] { ReadPointCloudFile(path); });
  };
  EXPECT_THAT(error("FIELDS y z i\n"), AllOf(HasSubstr("a.pcd"), HasSubstr("no field 'x'"), HasSubstr("'y z i'")));
  EXPECT_THAT(error("FIELDS x y i\n"), HasSubstr("no field 'z'"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 1 4 4\nTYPE U F F\n"), HasSubstr("'x' that is no single floating-point"));
  EXPECT_THAT(error("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 2 1\n"), HasSubstr("'y' that is no single"));
  EXPECT_EQ(error("FIELDS x y z i\n"), "(no UserError)");
}

TEST(ReadPointCloudFile, NamesTheLineOfDamagedText) {
  const TempFolder folder;
  const auto error = [&](const std::string& body) {
    const std::string path = folder.Write("a.pcd", "FIELDS x y z\nPOINTS 2\nDATA ascii\n" + body);
    return UserErrorOf([&] { ReadPointCloudFile(path); });
  };
  EXPECT_THAT(error("1 2 3\n1 2 x3\n"), AllOf(HasSubstr("line 5"), HasSubstr("'x3' is not a number")));
  EXPECT_THAT(error("1 2 3\n\n1 2\n 1 "), AllOf(HasSubstr("line 6"), HasSubstr("2 values instead of 3")));
  EXPECT_THAT(error("1 2 3 4\n1 2 3\n"), AllOf(HasSubstr("line 4"), HasSubstr("4 values instead of 3")));
  EXPECT_THAT(error("1.0000 2.0000 3.0000\n"), AllOf(HasSubstr("2 points"), HasSubstr("has 1")));
  EXPECT_THAT(error("1 2 3\n1 2 3\n1 2 3\n"), AllOf(HasSubstr("2 points"), HasSubstr("has 3")));
}

TEST(ReadPointCloudFile, RefusesWhatCannotBeReadOrUnpacked) {
  const TempFolder folder;
  const auto error = [](const std::string& path) { return UserErrorOf([&] { ReadPointCloudFile(path); }); };
  EXPECT_THAT(error(folder.File("none.pcd")), HasSubstr("does not exist"));
  EXPECT_THAT(error(folder.path()), HasSubstr("is a folder"));
  EXPECT_THAT(error(folder.Write("empty.pcd", "")), HasSubstr("is empty"));
  const std::string packed = "FIELDS x y z\nPOINTS 100\nDATA binary_compressed\n" + RawValues<uint32_t>({1000, 1200}) +
                             std::string(1000, '\xff');
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  EXPECT_THAT(error(folder.Write("noise.pcd", packed)), AllOf(HasSubstr("noise.pcd"), HasSubstr("cannot be unpacked")));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "PCL speaks where only we do.";
  folder.Write("huge.pcd", "");
  std::filesystem::resize_file(folder.File("huge.pcd"), (size_t{1} << 30) + 1);  // Sparse: takes no room.
  EXPECT_THAT(error(folder.File("huge.pcd")), HasSubstr("too long for one sweep"));
  if (::geteuid() != 0) {  // The superuser may read anything.
    const std::string locked = folder.Write("locked.pcd", BinaryPcd({1, 1, 1, 1}));
    std::filesystem::permissions(locked, std::filesystem::perms::none);
    EXPECT_THAT(error(locked), HasSubstr("check its permissions"));
  }
}

// Whatever becomes of a file, reading it throws a UserError or gives finite points.
void ExpectErrorOrFinitePoints(const std::string& path) {
  try {
    const PointCloudFile file = ReadPointCloudFile(path);
    EXPECT_TRUE(file.raw_times.empty() || file.raw_times.size() == file.sweep.points.size());
    for (const Eigen::Vector3f& point : file.sweep.points) ASSERT_TRUE(point.allFinite());
    for (const double time : file.raw_times) ASSERT_TRUE(std::isfinite(time));
  } catch (const UserError&) {
  }
}

TEST(ReadPointCloudFile, SurvivesDamageOfAnyKind) {
  const TempFolder folder;
  const pcl::PCLPointCloud2 cloud = PclCloud(40);
  const Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  const Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  pcl::PCDWriter pcd;
  pcl::PLYWriter ply;
  std::vector<std::string> sound;
  const std::string path = folder.File("a");
  ASSERT_EQ(pcd.writeASCII(path, cloud, origin, orientation, 8), 0);
  sound.push_back(ReadWhole(path));
  ASSERT_EQ(pcd.writeBinary(path, cloud, origin, orientation), 0);
  sound.push_back(ReadWhole(path));
  ASSERT_EQ(pcd.writeBinaryCompressed(path, cloud, origin, orientation), 0);
  sound.push_back(ReadWhole(path));
  ASSERT_EQ(ply.writeASCII(path, cloud, origin, orientation, 8, false), 0);
  sound.push_back(ReadWhole(path));
  ASSERT_EQ(ply.writeBinary(path, cloud, origin, orientation, true), 0);
  sound.push_back(ReadWhole(path));

  Random random(20240607);
  const auto below = [&random](size_t end) {
    return static_cast<size_t>(random.Uniform(0.0, static_cast<double>(end)));
  };
  for (const std::string& contents : sound) {
    const size_t header = std::min<size_t>(contents.size(), 400);
    for (int i = 0; i < 400; ++i) {
      std::string damaged = contents;
      // Bytes of any value, digits for digits (other counts and sizes), lines twice or gone, the end cut off.
      const size_t num_changes = 1 + below(4);
      for (size_t change = 0; change < num_changes; ++change) {
        const size_t end = random.Uniform() < 0.7 ? header : damaged.size();
        const size_t at = below(std::min(end, damaged.size()));
        const double kind = random.Uniform();
        if (kind < 0.3) {
          damaged[at] = static_cast<char>(random.Bits());
        } else if (kind < 0.7) {
          const size_t digit = damaged.find_first_of("0123456789", at);
          if (digit != std::string::npos) damaged[digit] = static_cast<char>('0' + below(10));
        } else if (kind < 0.8) {
          damaged.insert(at, std::to_string(random.Bits() >> below(64)));
        } else if (kind < 0.9) {
          const size_t begin = damaged.rfind('\n', at) + 1;  // 0 without one.
          const std::string line = damaged.substr(begin, damaged.find('\n', at) - begin + 1);
          if (random.Uniform() < 0.5) {
            damaged.insert(begin, line);
          } else if (line.size() < damaged.size()) {
            damaged.erase(begin, line.size());
          }
        } else {
          damaged.resize(std::max<size_t>(1, at));
        }
      }
      ExpectErrorOrFinitePoints(folder.Write("b", damaged));
      if (HasFatalFailure()) FAIL() << "change " << i << " of\n" << contents.substr(0, 50);
    }
  }
}

}  // namespace
}  // namespace arborslam
