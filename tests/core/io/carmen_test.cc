#include "core/io/carmen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/geometry/angles.h"
#include "core/io/scan_source.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A FLASER line with these readings; the lidar and the robot are at (x, 0, 0).
std::string Sick(const std::string& readings, size_t count, double x, double stamp) {
  const std::string pose = std::to_string(x) + " 0 0 ";
  return "FLASER " + std::to_string(count) + " " + readings + " " + pose + pose + std::to_string(stamp) + " host 0\n";
}

std::vector<LaserScan> ReadAll(const std::string& path) {
  std::vector<LaserScan> scans;
  const std::unique_ptr<ScanSource> source = OpenScanSource(path);
  while (const std::optional<Scan> scan = source->Next()) scans.push_back(std::get<LaserScan>(*scan));
  EXPECT_EQ(source->NumScans(), scans.size());
  return scans;
}

std::vector<std::string> NoticesOf(const std::string& path) { return CarmenScanSource(path).Notices(); }

class CarmenTest : public testing::Test {
 protected:
  std::string Write(const std::string& text) const { return folder_.Write("run.clf", text); }
  std::string ErrorOf(const std::string& text) const {
    const std::string path = Write(text);
    return UserErrorOf([&path] { CarmenScanSource source(path); });
  }

  const TempFolder folder_;
};

TEST_F(CarmenTest, ReadsAScanWithItsOdometry) {
  const std::string path = Write(
      "# a comment\nPARAM robot_use_laser on nohost 0\n\n"
      "FLASER 3 1.25 2 30.5 1 2 0.5 1 2 0.5 10.25 host 0.1\n"
      "FLASER 3 1 2 3 1.5 2 0.6 1.5 2 0.6 10.5 host 0.2\n");
  const std::vector<LaserScan> scans = ReadAll(path);
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[0].stamp, 10.25);
  EXPECT_THAT(scans[0].ranges, ElementsAre(1.25f, 2.0f, 30.5f));
  ASSERT_TRUE(scans[0].odometry && scans[1].odometry);
  EXPECT_TRUE(scans[0].odometry->IsApprox(SE2(1.0, 2.0, 0.5)));
  EXPECT_TRUE(scans[1].odometry->IsApprox(SE2(1.5, 2.0, 0.6)));
  EXPECT_THAT(NoticesOf(path), ElementsAre(HasSubstr("3 readings are taken to cover half a circle")));
}

// 180 readings leave the last degree out, 181 and 361 go from side to side.
TEST_F(CarmenTest, BearingsOfHalfACircle) {
  for (const auto& [count, step, last] : {std::tuple(size_t{180}, 1.0, 89.0), std::tuple(size_t{181}, 1.0, 90.0),
                                          std::tuple(size_t{360}, 0.5, 89.5), std::tuple(size_t{361}, 0.5, 90.0)}) {
    std::string readings;
    for (size_t i = 0; i < count; ++i) readings += (i > 0 ? " 2" : "2");
    const std::string path = Write(Sick(readings, count, 0.0, 1.0) + Sick(readings, count, 1.0, 2.0));
    const LaserScan scan = ReadAll(path).at(0);
    EXPECT_NEAR(scan.Bearing(0), -0.5 * kPi, 1e-12);
    EXPECT_NEAR(scan.bearing_increment, step * kPi / 180.0, 1e-12) << count;
    EXPECT_NEAR(scan.Bearing(count - 1), last * kPi / 180.0, 1e-12) << count;
    EXPECT_THAT(NoticesOf(path), IsEmpty());
  }
}

TEST_F(CarmenTest, ReadsRobotLaserMessages) {
  const auto line = [](double x, double stamp) {
    const std::string pose = std::to_string(x) + " 2 0.5 ";
    return "ROBOTLASER1 0 -1.5 3.0 0.75 40.0 0.01 0 4 1 39.99 40 55 2 7 8 " + pose + pose + "0.1 0.2 0.3 0.4 0 " +
           std::to_string(stamp) + " host 0\n";
  };
  const std::vector<LaserScan> scans = ReadAll(Write(line(1.0, 5.0) + line(2.0, 6.0)));
  ASSERT_EQ(scans.size(), 2u);
  EXPECT_EQ(scans[1].stamp, 6.0);
  EXPECT_EQ(scans[0].bearing_min, -1.5);
  EXPECT_EQ(scans[0].bearing_increment, 0.75);
  const float none = std::numeric_limits<float>::infinity();
  EXPECT_THAT(scans[0].ranges, ElementsAre(1.0f, 39.99f, none, none));
  EXPECT_TRUE(scans[1].odometry->IsApprox(SE2(2.0, 2.0, 0.5)));
}

TEST_F(CarmenTest, OfBothKindsTheMoreFrequentIsRead) {
  const std::string robot = "ROBOTLASER1 0 -1 2 1 40 0 0 1 1 0 0 0 0 0 0 0 0 0 0 0 0 3 host 0\n";
  const std::string path = Write(Sick("1 2", 2, 0.0, 1.0) + robot + Sick("3 4", 2, 1.0, 2.0));
  EXPECT_EQ(ReadAll(path).size(), 2u);
  EXPECT_THAT(NoticesOf(path), testing::Contains(HasSubstr("FLASER is read")));
}

TEST_F(CarmenTest, KnowsWhatDidNotComeBack) {
  const std::vector<LaserScan> scans =
      ReadAll(Write(Sick("81.83 81.91 inf -1 80", 5, 0.0, 1.0) + Sick("1 1 1 1 1", 5, 1.0, 2.0)));
  const float none = std::numeric_limits<float>::infinity();
  EXPECT_THAT(scans[0].ranges, ElementsAre(none, none, none, none, 80.0f));
}

// A driver that cuts at 50 m gives that very range again and again; a far wall scatters.
TEST_F(CarmenTest, ARangeThatADriverCutsAtIsNoReturn) {
  std::string cut;
  std::string wall;
  for (int i = 0; i < 100; ++i) {
    cut += Sick("50.00 1 49.5", 3, i, i);
    wall += Sick(std::to_string(49.95 + 0.01 * (i % 6)) + " 1 2", 3, i, i);
  }
  // 49.5 m is there as often: not cut, a wall.
  EXPECT_EQ(ReadAll(Write(cut)).at(0).ranges[0], 50.0f);
  std::string alone;
  for (int i = 0; i < 100; ++i) alone += Sick("50.00 1 " + std::string(i % 20 == 0 ? "49.5" : "48"), 3, i, i);
  const std::vector<LaserScan> scans = ReadAll(Write(alone));
  EXPECT_TRUE(std::isinf(scans[0].ranges[0]));
  EXPECT_EQ(scans[0].ranges[2], 49.5f);
  for (const LaserScan& scan : ReadAll(Write(wall))) EXPECT_TRUE(std::isfinite(scan.ranges[0]));
}

TEST_F(CarmenTest, ScansWhoseStampsRunBackwardsAreKept) {
  const std::string path = Write(Sick("1 2", 2, 0.0, 1.0) + Sick("1 2", 2, 0.1, 2.0) + Sick("1 2", 2, 0.2, 3.9) +
                                 Sick("1 2", 2, 0.3, 3.0) + Sick("1 2", 2, 0.4, 4.0));
  const std::vector<LaserScan> scans = ReadAll(path);
  ASSERT_EQ(scans.size(), 5u);
  const std::vector<double> expected = {1.0, 2.0, 2.5, 3.0, 4.0};
  for (size_t i = 0; i < scans.size(); ++i) {
    EXPECT_DOUBLE_EQ(scans[i].stamp, expected[i]);
    EXPECT_NEAR(scans[i].odometry->x(), 0.1 * static_cast<double>(i), 1e-9);
  }
  EXPECT_THAT(NoticesOf(path), testing::Contains(AllOf(HasSubstr("1 of the 5 stamps"), HasSubstr("no scan is lost"))));
}

TEST_F(CarmenTest, WithoutPosesOnTheScansOdomMessagesAreInterpolated) {
  const std::string path = Write("ODOM 0 0 0 0 0 0 1 host 0\n" + Sick("1 2", 2, 0.0, 1.0) + Sick("1 2", 2, 0.0, 1.5) +
                                 "ODOM 2 0 1 0 0 0 2 host 0\n" + Sick("1 2", 2, 0.0, 2.5));
  const std::vector<LaserScan> scans = ReadAll(path);
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_TRUE(scans[0].odometry->IsApprox(SE2(0.0, 0.0, 0.0)));
  EXPECT_TRUE(scans[1].odometry->IsApprox(SE2(1.0, 0.0, 0.5)));
  EXPECT_TRUE(scans[2].odometry->IsApprox(SE2(2.0, 0.0, 1.0)));
}

// The line's pose is that of the message before, and the scan was made half a period later.
TEST_F(CarmenTest, PosesThatRepeatTheLastOdomMessageAreInterpolated) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const std::string pose = std::to_string(i) + " 0 0 ";
    text += "ODOM " + pose + "0 0 0 " + std::to_string(i) + " host 0\n";
    text += Sick("1 2", 2, i, i + 0.5);
  }
  const std::vector<LaserScan> scans = ReadAll(Write(text));
  ASSERT_EQ(scans.size(), 20u);
  for (size_t i = 0; i < 19; ++i) EXPECT_NEAR(scans[i].odometry->x(), static_cast<double>(i) + 0.5, 1e-9);
  // Nothing is known beyond the last message.
  EXPECT_NEAR(scans[19].odometry->x(), 19.0, 1e-9);
}

// A scan's clock that ran ahead takes its pose not farther than to the next message.
TEST_F(CarmenTest, InterpolationStaysBetweenTheMessagesAroundTheLine) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    text += "ODOM " + std::to_string(i) + " 0 0 0 0 0 " + std::to_string(i) + " host 0\n";
    text += Sick("1 2", 2, i, i == 19 ? 100.0 : i == 7 ? 8.25 : i + 0.5);
  }
  const std::vector<LaserScan> scans = ReadAll(Write(text));
  EXPECT_NEAR(scans[6].odometry->x(), 6.5, 1e-9);
  EXPECT_NEAR(scans[7].odometry->x(), 8.0, 1e-9);
  EXPECT_NEAR(scans[8].odometry->x(), 8.5, 1e-9);
}

TEST_F(CarmenTest, WithoutAnyMotionThereIsNoOdometry) {
  const std::string path = Write(Sick("1 2", 2, 0.0, 1.0) + Sick("1 3", 2, 0.0, 2.0));
  for (const LaserScan& scan : ReadAll(path)) EXPECT_FALSE(scan.odometry.has_value());
  EXPECT_THAT(NoticesOf(path), testing::Contains(HasSubstr("no wheel odometry")));
}

// The lidar sits 0.2 m ahead of the robot's centre; that stays so in a raw log.
TEST_F(CarmenTest, ALidarAheadOfTheWheels) {
  const std::string path = Write(
      "FLASER 2 1 2 0.2 0 0 0 0 0 1 host 0\n"
      "FLASER 2 1 2 0 0.2 1.570796 0 0 1.570796 2 host 0\n");
  EXPECT_TRUE(ReadAll(path).at(1).odometry->IsApprox(SE2(0.0, 0.2, 1.570796)));
}

TEST_F(CarmenTest, OfACorrectedLogTheOdometryIsUsed) {
  const std::string path = Write(
      "FLASER 2 1 2 0 0 0 0 0 0 1 host 0\n"
      "FLASER 2 1 2 1 0.1 0.1 1 0 0 2 host 0\n"
      "FLASER 2 1 2 2 0.5 0.3 2 0 0 3 host 0\n");
  EXPECT_TRUE(ReadAll(path).at(2).odometry->IsApprox(SE2(2.0, 0.0, 0.0)));
  EXPECT_THAT(NoticesOf(path), testing::Contains(HasSubstr("corrected logs")));
}

TEST_F(CarmenTest, ALastLineThatIsCutShortIsLeftOut) {
  const std::string whole = Sick("1 2", 2, 0.0, 1.0) + Sick("1 2", 2, 1.0, 2.0);
  const std::string path = Write(whole + "FLASER 2 1 2 0.5 0.");
  EXPECT_EQ(ReadAll(path).size(), 2u);
  EXPECT_THAT(NoticesOf(path), testing::Contains(HasSubstr("last line is cut short")));
  // Anywhere else it is an error.
  EXPECT_THAT(ErrorOf("FLASER 2 1 2 0.5 0.\n" + whole),
              AllOf(HasSubstr("run.clf, line 1"), HasSubstr("6 fields instead of 13"), HasSubstr("remove it")));
}

TEST_F(CarmenTest, NamesWhatIsWrong) {
  const std::string good = Sick("1 2", 2, 0.0, 1.0);
  const std::string end = " host 0\n" + good;
  EXPECT_THAT(ErrorOf("PARAM a b\nODOM 1 2 3 0 0 0 1 host 0\n"),
              AllOf(HasSubstr("holds no scans"), HasSubstr("FLASER")));
  EXPECT_THAT(ErrorOf(good + "FLASER 2 1 x 0 0 0 0 0 0 1" + end), AllOf(HasSubstr("'x'"), HasSubstr("not a number")));
  EXPECT_THAT(ErrorOf(good + "FLASER 2 1 2 0 0 inf 0 0 0 1" + end), AllOf(HasSubstr("theta"), HasSubstr("'inf'")));
  EXPECT_THAT(ErrorOf(good + "FLASER 2 1 2 1e12 0 0 0 0 0 1" + end), AllOf(HasSubstr("x '1e12'"), HasSubstr("range")));
  EXPECT_THAT(ErrorOf(good + "FLASER 2 1 2 0 0 0 0 0 0 late" + end), AllOf(HasSubstr("stamp 'late'")));
  EXPECT_THAT(ErrorOf(good + "FLASER 2 1 2 3 0 0 0 0 0 0 1" + end), HasSubstr("14 columns instead of 13"));
  EXPECT_THAT(ErrorOf(good + "FLASER 2.5 1 2 0 0 0 0 0 0 1" + end), HasSubstr("not an integer"));
  EXPECT_THAT(ErrorOf(good + "FLASER -2 1 2 0 0 0 0 0 0 1" + end), HasSubstr("is -2"));
  EXPECT_THAT(ErrorOf(good + "FLASER 0 0 0 0 0 0 0 1" + end), HasSubstr("no readings"));
  EXPECT_THAT(ErrorOf(good + "FLASER 2000000000 1 2 0 0 0 0 0 0 1" + end), HasSubstr("instead of 2000000011"));
  EXPECT_THAT(ErrorOf(good + "FLASER\n" + good), HasSubstr("1 fields instead of 2"));
  EXPECT_THAT(ErrorOf(good + "ODOM 1 2 3\n" + good), AllOf(HasSubstr("4 fields instead of 10"), HasSubstr("line 2")));
  EXPECT_THAT(ErrorOf(good + "ROBOTLASER1 0 1 1 1 40 0 0 9 1 2\n" + good), HasSubstr("ROBOTLASER1 has 11 fields"));
  EXPECT_THAT(ErrorOf(good + "ROBOTLASER1 0 -1 2 bad 40 0 0 1 1 0 0 0 0 0 0 0 0 0 0 0 0 3 host 0\n" + good),
              HasSubstr("'bad'"));
}

TEST_F(CarmenTest, IsKnownByNameAndByContent) {
  const std::string scan = Sick("1 2", 2, 0.0, 1.0);
  EXPECT_TRUE(CarmenScanSource::Recognises(folder_.Write("a.clf", "x\n")));
  EXPECT_TRUE(CarmenScanSource::Recognises(folder_.Write("a.log", "# logger\nPARAM x y\n" + scan)));
  EXPECT_TRUE(CarmenScanSource::Recognises(folder_.Write("a", scan)));
  EXPECT_FALSE(CarmenScanSource::Recognises(folder_.Write("b.log", "today nothing happened\n")));
  EXPECT_FALSE(CarmenScanSource::Recognises(folder_.Write("c.log", std::string(100, '\0'))));
  EXPECT_FALSE(CarmenScanSource::Recognises(folder_.path()));
  EXPECT_FALSE(CarmenScanSource::Recognises(folder_.File("missing.log")));
}

}  // namespace
}  // namespace arborslam
