#include "core/io/sweep_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/kitti_bin.h"
#include "core/io/point_cloud_file.h"
#include "core/io/scan_source.h"
#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

// A sweep of one point, told from others by its x.
LidarSweep SweepAt(float x) {
  LidarSweep sweep;
  sweep.points = {{x, 2.0f, 3.0f}};
  return sweep;
}

// A folder with `names`.bin, the i-th with a point at x = i + 1; `stamps` beside them unless empty.
void WriteBins(const TempFolder& folder, const std::vector<std::string>& names, const std::string& stamps) {
  for (size_t i = 0; i < names.size(); ++i) {
    WriteKittiBin(folder.File(names[i] + ".bin"), SweepAt(static_cast<float>(i + 1)));
  }
  if (!stamps.empty()) folder.Write("timestamps.txt", stamps);
}

std::vector<LidarSweep> ReadAll(ScanSource* source) {
  std::vector<LidarSweep> sweeps;
  while (const std::optional<Scan> scan = source->Next()) sweeps.push_back(std::get<LidarSweep>(*scan));
  EXPECT_FALSE(source->Next());
  EXPECT_EQ(source->NumScans(), sweeps.size());
  return sweeps;
}

std::vector<LidarSweep> ReadAll(const std::string& path, const SweepFolderOptions& options = {}) {
  SweepFolder source(path, options);
  return ReadAll(&source);
}

std::vector<double> Starts(const std::vector<LidarSweep>& sweeps) {
  std::vector<double> starts;
  for (const LidarSweep& sweep : sweeps) starts.push_back(sweep.start);
  return starts;
}

std::vector<float> FirstX(const std::vector<LidarSweep>& sweeps) {
  std::vector<float> xs;
  for (const LidarSweep& sweep : sweeps) xs.push_back(sweep.points.at(0).x());
  return xs;
}

std::string ErrorOf(const std::string& path) {
  return UserErrorOf([&] { SweepFolder source(path, {}); });
}

TEST(SweepFolder, FindsSweepsAndStampsWhereRecordingsHaveThem) {
  const TempFolder folder;
  struct Layout {
    std::string sweeps;
    std::string stamps;
    std::vector<std::string> inputs;
  };
  const Layout layouts[] = {
      {"a", "a/timestamps.txt", {"a", "a/", "a/."}},
      {"b", "times.txt", {"b", "b/"}},
      {"c/clouds", "c/timestamps.txt", {"c", "c/", "c/clouds", "c/clouds/", "c/../c"}},
      {"d/velodyne", "d/times.txt", {"d", "d/velodyne"}},
      {"e/velodyne_points/data",
       "e/velodyne_points/timestamps.txt",
       {"e", "e/velodyne_points/data", "e/velodyne_points/data/"}},
      {"f/velodyne_points/data", "f/times.txt", {"f"}},
      {"g/velodyne_points/data", "g/velodyne_points/data/times.txt", {"g", "g/velodyne_points/data"}},
  };
  for (const Layout& layout : layouts) {
    std::filesystem::create_directories(folder.File(layout.sweeps));
    for (const char* name : {"9", "10", "8"}) {
      WriteKittiBin(folder.File(layout.sweeps + "/" + name + ".bin"), SweepAt(std::stof(name)));
    }
    folder.Write(layout.stamps, "100.0\n100.1\n100.2\n");
    for (const std::string& input : layout.inputs) {
      const std::vector<LidarSweep> sweeps = ReadAll(OpenScanSource(folder.File(input)).get());
      EXPECT_THAT(FirstX(sweeps), ElementsAre(8.0f, 9.0f, 10.0f)) << input;
      EXPECT_THAT(Starts(sweeps), ElementsAre(100.0, 100.1, 100.2)) << input;
      for (const LidarSweep& sweep : sweeps) EXPECT_NEAR(sweep.duration, 0.1, 1e-9) << input;
    }
    std::filesystem::remove(folder.File(layout.stamps));
  }
}

TEST(SweepFolder, FindsStampsAboveTheWorkingFolder) {
  const TempFolder folder;
  std::filesystem::create_directories(folder.File("clouds"));
  WriteKittiBin(folder.File("clouds/a1.bin"), SweepAt(1.0f));
  folder.Write("timestamps.txt", "7\n");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.File("clouds"));
  EXPECT_THAT(Starts(ReadAll(".")), ElementsAre(7.0));
  EXPECT_THAT(Starts(ReadAll("..")), ElementsAre(7.0));
  std::filesystem::current_path(folder.path());
  EXPECT_THAT(Starts(ReadAll("clouds")), ElementsAre(7.0));
  std::filesystem::current_path(before);
}

TEST(SweepFolder, PrefersTheSubfolderAndLeavesOtherFilesAside) {
  const TempFolder folder;
  std::filesystem::create_directories(folder.File("clouds/5.bin"));
  WriteKittiBin(folder.File("clouds/1.BIN"), SweepAt(1.0f));
  WriteKittiBin(folder.File("clouds/._1.bin"), SweepAt(2.0f));
  folder.Write("clouds/readme.md", "x");
  folder.Write("map.ply", "a map beside the sweeps");
  EXPECT_THAT(FirstX(ReadAll(folder.path())), ElementsAre(1.0f));
}

TEST(SweepFolder, AStampNamesTheStartTheMiddleOrTheEnd) {
  const TempFolder folder;
  WriteBins(folder, {"1", "2"}, "10.0\n10.2\n");
  EXPECT_THAT(Starts(ReadAll(folder.path(), {"start", 0.0})), ElementsAre(10.0, 10.2));
  EXPECT_THAT(Starts(ReadAll(folder.path(), {"middle", 0.0})),
              ElementsAre(DoubleNear(9.9, 1e-9), DoubleNear(10.1, 1e-9)));
  const std::vector<LidarSweep> sweeps = ReadAll(folder.path(), {"end", 0.05});
  EXPECT_THAT(Starts(sweeps), ElementsAre(DoubleNear(9.95, 1e-9), DoubleNear(10.15, 1e-9)));
  EXPECT_EQ(sweeps[0].duration, 0.05);
}

TEST(SweepFolder, TakesTheNamesForStampsInTheirOrder) {
  const TempFolder folder;
  WriteBins(folder, {"1664464000.5", "1664464000.3000", "1664464000.40"}, "");
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), Contains(HasSubstr("names of their files")));
  const std::vector<LidarSweep> sweeps = ReadAll(&source);
  EXPECT_THAT(FirstX(sweeps), ElementsAre(2.0f, 3.0f, 1.0f));
  EXPECT_THAT(Starts(sweeps), ElementsAre(1664464000.3, 1664464000.4, 1664464000.5));
}

TEST(SweepFolder, NamesThatAreStampsGiveTheOrderAlsoWhereAFileStampsThem) {
  const TempFolder folder;
  WriteBins(folder, {"1664464000.5", "1664464000.3000", "1664464001.40"}, "1\n2\n3\n");
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), Not(Contains(HasSubstr("named"))));
  const std::vector<LidarSweep> sweeps = ReadAll(&source);
  EXPECT_THAT(FirstX(sweeps), ElementsAre(2.0f, 1.0f, 3.0f));
  EXPECT_THAT(Starts(sweeps), ElementsAre(1.0, 2.0, 3.0));
}

TEST(SweepFolder, WithoutStampsTheSweepsComeAtTenHertzAndTheUserIsTold) {
  const TempFolder folder;
  WriteBins(folder, {"0", "1", "2"}, "");
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), ElementsAre("The points carry no times.", HasSubstr("10 Hz")));
  EXPECT_THAT(Starts(ReadAll(&source)), ElementsAre(0.0, DoubleNear(0.1, 1e-9), DoubleNear(0.2, 1e-9)));
}

TEST(SweepFolder, TellsOfNamesThatLookAsIfFilesWereMissing) {
  const auto notices = [](const std::vector<std::string>& names, const std::string& stamps) {
    const TempFolder folder;
    WriteBins(folder, names, stamps);
    return SweepFolder(folder.path(), {}).Notices();
  };
  EXPECT_THAT(notices({"a1", "a2", "a4"}, ""),
              Contains(AllOf(HasSubstr("'a2.bin' and 'a4.bin'"), HasSubstr("evenly"))));
  EXPECT_THAT(notices({"a1", "a2", "a4"}, "1\n2\n4\n"), Not(Contains(HasSubstr("evenly"))));
  EXPECT_THAT(notices({"a2", "a4", "a6"}, ""), Not(Contains(HasSubstr("evenly"))));
  EXPECT_THAT(notices({"a1", "a2", "b3"}, "1\n2\n3\n"),
              Contains(AllOf(HasSubstr("'a2.bin' and 'b3.bin'"), HasSubstr("not named alike"))));
  EXPECT_THAT(notices({"a", "b"}, ""), Contains(HasSubstr("not named alike")));
}

TEST(SweepFolder, RepairsStampsThatDoNotRise) {
  const TempFolder folder;
  WriteBins(folder, {"1", "2", "3", "4"}, "# stamps\n1.0\n1.1\n1.1\n1.3\n");
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), Contains(HasSubstr("1 of the 4 stamps are not later")));
  const std::vector<double> starts = Starts(ReadAll(&source));
  ASSERT_EQ(starts.size(), 4u);
  for (size_t i = 1; i < 4; ++i) EXPECT_GT(starts[i], starts[i - 1]);
  EXPECT_EQ(starts[0], 1.0);
  EXPECT_EQ(starts[3], 1.3);
}

TEST(SweepFolder, AssumesTheDurationWhenSweepsWereLeftOut) {
  const TempFolder folder;
  WriteBins(folder, {"1", "2", "3"}, "1\n2.5\n4\n");
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), Contains(AllOf(HasSubstr("1.5 s apart"), HasSubstr("sweep_duration"))));
  EXPECT_EQ(ReadAll(&source)[0].duration, 0.1);
  EXPECT_THAT(SweepFolder(folder.path(), {"start", 0.2}).Notices(), Not(Contains(HasSubstr("apart"))));
}

TEST(SweepFolder, RefusesStampsThatCannotBeThoseOfTheSweeps) {
  const TempFolder folder;
  WriteBins(folder, {"1", "2"}, "1\n2\n3\n");
  EXPECT_THAT(ErrorOf(folder.path()), AllOf(HasSubstr("timestamps.txt"), HasSubstr("3 stamps"), HasSubstr("2 sweeps")));
  folder.Write("timestamps.txt", "1\nnoon\n");
  EXPECT_THAT(ErrorOf(folder.path()), AllOf(HasSubstr("timestamps.txt, line 2"), HasSubstr("'noon'")));
}

TEST(SweepFolder, RefusesSweepsOfMoreThanOneKind) {
  const TempFolder folder;
  WriteBins(folder, {"1", "2"}, "");
  WritePcd(folder.File("3.pcd"), SweepAt(3.0f));
  EXPECT_THAT(ErrorOf(folder.path()), AllOf(HasSubstr("more than one kind"), HasSubstr("2 .bin and 1 .pcd")));
}

TEST(SweepFolder, GivesADamagedFileAsASweepWithItsFault) {
  const TempFolder folder;
  LidarSweep many = SweepAt(1.0f);
  many.points.resize(200, many.points[0]);
  for (const char* name : {"1", "2", "3"}) WriteKittiBin(folder.File(std::string(name) + ".bin"), many);
  folder.Write("2.bin", "damaged");
  SweepFolder source(folder.path(), {});
  const std::vector<LidarSweep> sweeps = ReadAll(&source);
  ASSERT_EQ(sweeps.size(), 3u);
  EXPECT_THAT(sweeps[1].fault, AllOf(HasSubstr("2.bin"), HasSubstr("7 bytes")));
  EXPECT_TRUE(sweeps[1].points.empty());
  for (const size_t whole : {0, 2}) {
    EXPECT_EQ(sweeps[whole].fault, "");
    EXPECT_EQ(sweeps[whole].points.size(), 200u);
  }
  folder.Write("1.bin", "damaged");
  EXPECT_EQ(ReadAll(folder.path()).size(), 3u);
  folder.Write("3.bin", "damaged");
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("1.bin"));
}

TEST(SweepFolder, GivesSweepsWithoutPoints) {
  const TempFolder folder;
  WriteBins(folder, {"1", "2", "3"}, "1.0\n1.1\n1.2\n");
  folder.Write("1.bin", "");
  folder.Write("3.bin", RawValues<float>({0, 0, 0, 1}));
  const std::vector<LidarSweep> sweeps = ReadAll(folder.path());
  ASSERT_THAT(sweeps, SizeIs(3));
  EXPECT_THAT(sweeps[0].points, IsEmpty());
  EXPECT_THAT(sweeps[1].points, SizeIs(1));
  EXPECT_THAT(sweeps[2].points, IsEmpty());
  EXPECT_EQ(sweeps[2].num_dropped, 1u);
}

TEST(SweepFolder, TakesASingleFileForARecording) {
  const TempFolder folder;
  WriteKittiBin(folder.File("a.bin"), SweepAt(4.0f));
  EXPECT_THAT(FirstX(ReadAll(OpenScanSource(folder.File("a.bin")).get())), ElementsAre(4.0f));
  WritePcd(folder.File("cloud"), SweepAt(5.0f));
  const std::vector<LidarSweep> sweeps = ReadAll(OpenScanSource(folder.File("cloud")).get());
  EXPECT_THAT(FirstX(sweeps), ElementsAre(5.0f));
  EXPECT_THAT(Starts(sweeps), ElementsAre(0.0));
}

// Sweeps of 200 points each in PCD files, the field `field` holding, in float64, what `time` gives for the sweep and
// for the part of it, in [0, 1].
template <typename Time>
void WriteTimedPcds(const TempFolder& folder, size_t num_sweeps, const std::string& field, const Time& time) {
  for (size_t i = 0; i < num_sweeps; ++i) {
    std::string body;
    for (int j = 0; j < 200; ++j) {
      // Out of order, as drivers give them that go ring by ring.
      const double part = static_cast<double>((j * 77) % 200) / 199.0;
      body += RawValues<float>({static_cast<float>(i + 1), 2.0f, static_cast<float>(part)});
      body += RawValues<double>({time(static_cast<double>(i), part)});
    }
    folder.Write(std::to_string(i) + ".pcd",
                 "FIELDS x y z " + field + "\nSIZE 4 4 4 8\nTYPE F F F F\nPOINTS 200\nDATA binary\n" + body);
  }
}

// That each point's time is that of its part of a sweep of 0.1 s that begins 0.1 s after the one before, the first at
// `first_start`.
void ExpectTenHertz(const std::vector<LidarSweep>& sweeps, double first_start) {
  for (size_t i = 0; i < sweeps.size(); ++i) {
    ASSERT_EQ(sweeps[i].times.size(), 200u);
    EXPECT_NEAR(sweeps[i].start, first_start + 0.1 * static_cast<double>(i), 1e-5);
    EXPECT_NEAR(sweeps[i].duration, 0.1, 1e-5);
    for (size_t j = 0; j < 200; ++j) {
      EXPECT_THAT(sweeps[i].times[j], FloatNear(0.1f * sweeps[i].points[j].z(), 1e-5f));
      EXPECT_GE(sweeps[i].times[j], 0.0f);
      EXPECT_LE(sweeps[i].times[j], sweeps[i].duration + 1e-6);
    }
  }
}

constexpr char kStamps[] = "1664464000.0\n1664464000.1\n1664464000.2\n";
constexpr double kStart = 1664464000.0;

TEST(SweepFolder, TimesRelativeToTheStampTellWhatTheStampIs) {
  for (const double shift : {0.0, -0.05, -0.1}) {
    const TempFolder folder;
    folder.Write("times.txt", kStamps);
    WriteTimedPcds(folder, 3, "t", [&](double, double part) { return 1e9 * (0.1 * part + shift); });
    SweepFolder source(folder.path(), {});
    EXPECT_THAT(source.Notices(), ElementsAre(AllOf(HasSubstr("'t'"), HasSubstr("nanoseconds"))));
    ExpectTenHertz(ReadAll(&source), kStart + shift);
  }
}

TEST(SweepFolder, TimesOnTheClockOfTheStampsTellWhatTheStampIs) {
  for (const double shift : {0.0, -0.05, -0.1}) {
    const TempFolder folder;
    folder.Write("times.txt", kStamps);
    WriteTimedPcds(folder, 3, "timestamp", [&](double i, double part) { return kStart + 0.1 * (i + part) + shift; });
    ExpectTenHertz(ReadAll(folder.path()), kStart + shift);
  }
}

TEST(SweepFolder, TimesOnAnotherClockCountFromTheFirstPoint) {
  // 0.0: the clock started with the recording, so that the first sweep's times look relative.
  for (const double epoch : {0.0, 5000.0}) {
    const TempFolder folder;
    folder.Write("times.txt", kStamps);
    WriteTimedPcds(folder, 3, "time_stamp", [&](double i, double part) { return 1e6 * (epoch + 0.1 * (i + part)); });
    ExpectTenHertz(ReadAll(folder.path()), kStart);
    ExpectTenHertz(ReadAll(folder.path(), {"middle", 0.0}), kStart - 0.05);
    ExpectTenHertz(ReadAll(folder.path(), {"end", 0.0}), kStart - 0.1);
  }
}

TEST(SweepFolder, AbsoluteTimesServeAsStampsWhenThereAreNone) {
  const TempFolder folder;
  WriteTimedPcds(folder, 3, "timestamp", [](double i, double part) { return kStart + 0.1 * (i + part); });
  SweepFolder source(folder.path(), {"end", 0.0});
  EXPECT_THAT(source.Notices(), Contains(HasSubstr("stamped by the times of their first points")));
  ExpectTenHertz(ReadAll(&source), kStart);
  // A sweep without points follows the one before it.
  folder.Write("1.pcd", "FIELDS x y z timestamp\nPOINTS 0\nDATA binary\n");
  EXPECT_THAT(Starts(ReadAll(folder.path())),
              ElementsAre(kStart, DoubleNear(kStart + 0.1, 1e-5), DoubleNear(kStart + 0.2, 1e-5)));
}

TEST(SweepFolder, WithoutStampsTheSweepsComeAsOftenAsTheyLast) {
  const TempFolder folder;
  WriteTimedPcds(folder, 3, "time", [](double, double part) { return 0.05 * part; });
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), Contains(HasSubstr("0.05 s apart (20 Hz)")));
  const std::vector<LidarSweep> sweeps = ReadAll(&source);
  EXPECT_NEAR(sweeps[2].start, 0.1, 1e-9);
  EXPECT_NEAR(sweeps[2].duration, 0.05, 1e-9);
}

TEST(SweepFolder, ASweepMayMissItsFirstAndLastReturns) {
  const TempFolder folder;
  folder.Write("times.txt", kStamps);
  WriteTimedPcds(folder, 3, "time", [](double, double part) { return 0.01 + 0.08 * part; });
  for (const LidarSweep& sweep : ReadAll(folder.path())) {
    EXPECT_NEAR(sweep.duration, 0.1, 1e-6);
    EXPECT_NEAR(*std::min_element(sweep.times.begin(), sweep.times.end()), 0.01f, 1e-6f);
    EXPECT_NEAR(*std::max_element(sweep.times.begin(), sweep.times.end()), 0.09f, 1e-6f);
  }
}

TEST(SweepFolder, PointsWithDamagedTimesAreLeftOut) {
  const TempFolder folder;
  folder.Write("times.txt", kStamps);
  WriteTimedPcds(folder, 3, "time", [](double i, double part) { return i == 1.0 && part == 1.0 ? 0.4 : 0.1 * part; });
  const std::vector<LidarSweep> sweeps = ReadAll(folder.path());
  EXPECT_THAT(sweeps[0].times, SizeIs(200));
  EXPECT_THAT(sweeps[1].times, SizeIs(199));
  EXPECT_THAT(sweeps[1].points, SizeIs(199));
  EXPECT_EQ(sweeps[1].num_dropped, 1u);
  EXPECT_EQ(sweeps[1].start, kStart + 0.1);
  EXPECT_NEAR(sweeps[1].duration, 0.1, 1e-6);
  EXPECT_THAT(sweeps[2].times, SizeIs(200));
}

TEST(SweepFolder, TellsWhenPointTimesMakeNoSense) {
  const TempFolder folder;
  folder.Write("times.txt", kStamps);
  WriteTimedPcds(folder, 3, "time", [](double, double) { return 12.0; });
  SweepFolder source(folder.path(), {});
  EXPECT_THAT(source.Notices(), ElementsAre(AllOf(HasSubstr("'time'"), HasSubstr("not used"))));
  for (const LidarSweep& sweep : ReadAll(&source)) EXPECT_THAT(sweep.times, IsEmpty());
}

TEST(SweepFolder, ReadsBackTheTimesThatWritePcdWrites) {
  const TempFolder folder;
  LidarSweep sweep;
  for (int i = 0; i < 1000; ++i) {
    sweep.points.emplace_back(1.0f, static_cast<float>(i), 0.5f);
    sweep.times.push_back(0.1f * static_cast<float>(i) / 1000.0f);
  }
  WritePcd(folder.File("1.pcd"), sweep);
  WritePcd(folder.File("2.pcd"), sweep);
  folder.Write("timestamps.txt", "5.0\n5.1\n");
  const std::vector<LidarSweep> sweeps = ReadAll(folder.path());
  EXPECT_EQ(sweeps[1].start, 5.1);
  EXPECT_EQ(sweeps[1].points, sweep.points);
  EXPECT_EQ(sweeps[1].times, sweep.times);
  EXPECT_NEAR(sweeps[1].duration, 0.1, 1e-9);
}

TEST(SweepFolderOptions, AreChecked) {
  EXPECT_EQ(SweepFolderOptions().Validate(), "");
  EXPECT_EQ((SweepFolderOptions{"middle", 0.1}.Validate()), "");
  EXPECT_EQ((SweepFolderOptions{"end", 10.0}.Validate()), "");
  EXPECT_THAT((SweepFolderOptions{"begin", 0.0}.Validate()), HasSubstr("stamp is"));
  EXPECT_THAT((SweepFolderOptions{"start", -0.1}.Validate()), HasSubstr("sweep_duration is -0.1"));
  EXPECT_THAT((SweepFolderOptions{"start", 11.0}.Validate()), HasSubstr("sweep_duration is 11"));
  EXPECT_THAT((SweepFolderOptions{"start", std::nan("")}.Validate()), HasSubstr("sweep_duration"));
  const std::string pose = "0.1 0 0.5 180 0 -90";
  EXPECT_EQ((SweepFolderOptions{"start", 0.0, pose, "lidar"}.Validate()), "");
  EXPECT_EQ((SweepFolderOptions{"start", 0.0, pose, "base"}.Validate()), "");
  EXPECT_THAT((SweepFolderOptions{"start", 0.0, "1 2 3", "lidar"}.Validate()), HasSubstr("T_base_lidar is"));
  EXPECT_THAT((SweepFolderOptions{"start", 0.0, "", "base"}.Validate()), HasSubstr("frame is 'base'"));
  EXPECT_THAT((SweepFolderOptions{"start", 0.0, pose, "map"}.Validate()), HasSubstr("frame is 'map'"));
}

TEST(ParsePose, ReadsSixNumbers) {
  const auto pose = ParsePose(" 1, -2 3e0,180 0 90 ");
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->translation(), Eigen::Vector3d(1.0, -2.0, 3.0));
  // About x first, then about z.
  EXPECT_LT((pose->linear() * Eigen::Vector3d(1.0, 2.0, 3.0) - Eigen::Vector3d(2.0, 1.0, -3.0)).norm(), 1e-12);
  for (const char* text : {"", "1 2 3 4 5", "1 2 3 4 5 6 7", "1 2 3 4 5 x", "1 2 3 4 5 nan", "1 2 3 4 5 6m"}) {
    EXPECT_FALSE(ParsePose(text).has_value()) << text;
  }
}

TEST(RecordedKitti, HasTenSweepsOfAStreet) {
  const std::string path = DataFolder() + "/kitti_raw";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set ARBORSLAM_DATA";
  const std::unique_ptr<ScanSource> source = OpenScanSource(path);
  EXPECT_THAT(source->Notices(), ElementsAre("The points carry no times.", HasSubstr("10 Hz")));
  const std::vector<LidarSweep> sweeps = ReadAll(source.get());
  ASSERT_THAT(sweeps, SizeIs(10));
  for (size_t i = 0; i < 10; ++i) {
    const LidarSweep& sweep = sweeps[i];
    EXPECT_NEAR(sweep.start, 0.1 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(sweep.duration, 0.1, 1e-9);
    EXPECT_GT(sweep.points.size(), 110000u);
    size_t num_near_ground = 0;
    for (const Eigen::Vector3f& point : sweep.points) {
      EXPECT_LT(point.norm(), 130.0f);
      num_near_ground += std::abs(point.z() + 1.8f) < 0.3f ? 1 : 0;
    }
    EXPECT_GT(num_near_ground, sweep.points.size() / 5);
  }
}

}  // namespace
}  // namespace arborslam
