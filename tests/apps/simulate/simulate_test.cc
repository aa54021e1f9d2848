#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "core/io/kitti_bin.h"
#include "core/io/map_io.h"
#include "core/io/npz.h"
#include "core/io/point_cloud_file.h"
#include "core/io/scan_source.h"
#include "core/io/trajectory_io.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/vineyard.h"

namespace arborslam {
namespace {

namespace fs = std::filesystem;

struct ProgramResult {
  int exit_code = -1;
  std::string output;  // stdout and stderr.
};

class SimulateTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / ("simulate_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Runs the program with `arguments`, in which "DIR" stands for a folder of this test.
  ProgramResult Run(std::string arguments) const {
    for (size_t at = 0; (at = arguments.find("DIR", at)) != std::string::npos;) {
      arguments.replace(at, 3, folder_.string());
      at += folder_.string().size();
    }
    const std::string command = std::string(ARBORSLAM_PROGRAM_DIR) + "/arborslam_simulate " + arguments + " 2>&1";
    ProgramResult result;
    FILE* const pipe = popen(command.c_str(), "r");
    std::array<char, 4096> buffer;
    for (size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) result.output.append(buffer.data(), n);
    const int status = pclose(pipe);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
  }

  // Runs the program, which must fail with one line that contains `expected` and leave no results behind.
  void ExpectError(const std::string& arguments, int exit_code, const std::string& expected) const {
    const ProgramResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments;
    EXPECT_NE(result.output.find(expected), std::string::npos) << arguments << ": " << result.output;
    EXPECT_EQ(result.output.find('\n'), result.output.size() - 1) << result.output;
    EXPECT_FALSE(fs::exists(folder_ / "out")) << arguments;
  }

  std::string Contents(const fs::path& path) const {
    std::ifstream file(folder_ / path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

  fs::path folder_;
};

TEST_F(SimulateTest, WritesScansAndGroundTruthOfTheOrchard) {
  const ProgramResult result =
      Run("--scenario planar_orchard --seed 7 --scans 12 --output DIR/a/b --set planar_orchard.rows=3");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(result.output.rfind("12 scans among ", 0), 0u) << result.output;

  PlanarOrchardOptions options;
  options.seed = 7;
  options.num_scans = 12;
  options.rows = 3;
  const PlanarOrchard orchard(options);
  const std::unique_ptr<ScanSource> source = OpenScanSource((folder_ / "a/b/scans.npz").string());
  const Trajectory3 truth = ReadTrajectory((folder_ / "a/b/ground_truth.tum").string());
  ASSERT_EQ(truth.poses.size(), 12u);
  for (size_t i = 0; i < 12; ++i) {
    const std::optional<Scan> next = source->Next();
    const LaserScan expected = orchard.Scan(i);
    ASSERT_TRUE(next.has_value());
    const auto* scan = std::get_if<LaserScan>(&*next);
    ASSERT_NE(scan, nullptr);
    EXPECT_EQ(scan->ranges, expected.ranges);
    EXPECT_EQ(scan->stamp, expected.stamp);
    EXPECT_NEAR(scan->bearing_min, expected.bearing_min, 1e-12);
    EXPECT_NEAR(scan->bearing_increment, expected.bearing_increment, 1e-12);
    EXPECT_EQ(truth.poses[i].stamp, expected.stamp);
    EXPECT_NEAR(truth.poses[i].position.x(), orchard.TruePose(i).x(), 1e-8);
    EXPECT_NEAR(truth.poses[i].position.y(), orchard.TruePose(i).y(), 1e-8);
  }
  EXPECT_FALSE(source->Next().has_value());
  EXPECT_NE(Contents("a/b/simulation.yaml").find("  seed: 7\n  rows: 3\n"), std::string::npos);
  // Exactly these files: nothing temporary is left behind.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "a/b"), {}), 3);
}

TEST_F(SimulateTest, ItsOwnConfigurationRepeatsTheRun) {
  ASSERT_EQ(
      Run("--scenario planar_orchard --seed 3 --scans 5 --output DIR/first --set planar_orchard.sway=0.1").exit_code,
      0);
  const ProgramResult second =
      Run("--scenario planar_orchard --config DIR/first/simulation.yaml --output DIR/second --quiet");
  ASSERT_EQ(second.exit_code, 0) << second.output;
  EXPECT_EQ(second.output, "");
  for (const char* file : {"scans.npz", "ground_truth.tum", "simulation.yaml"}) {
    EXPECT_FALSE(Contents(fs::path("first") / file).empty());
    EXPECT_EQ(Contents(fs::path("first") / file), Contents(fs::path("second") / file)) << file;
  }
  ASSERT_EQ(Run("--scenario planar_orchard --seed 4 --scans 5 --output DIR/third").exit_code, 0);
  EXPECT_NE(Contents("first/scans.npz"), Contents("third/scans.npz"));
}

TEST_F(SimulateTest, WritesSweepsWithTheirTruth) {
  const std::string small = " --scans 3 --set vineyard.columns=90 vineyard.max_range=20 --output DIR/";
  const ProgramResult result = Run("--scenario vineyard --seed 5" + small + "bin");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(result.output.rfind("3 sweeps among ", 0), 0u) << result.output;
  // Exactly these files: nothing temporary is left behind.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "bin"), {}), 7);
  for (const char* file : {"timestamps.txt", "ground_truth.tum", "gt_map.yaml", "gt_map.pgm", "controls.csv",
                           "simulation.yaml", "clouds/000000.bin", "clouds/000002.bin"}) {
    EXPECT_FALSE(Contents(fs::path("bin") / file).empty()) << file;
  }
  EXPECT_EQ(Contents("bin/timestamps.txt"), "0.000000000\n0.100000000\n0.200000000\n");
  EXPECT_EQ(Contents("bin/controls.csv").rfind("stamp,forward_velocity,lateral_velocity,yaw_rate\n0.050000000,", 0),
            0u);

  VineyardOptions options;
  options.run.seed = 5;
  options.run.num_scans = 3;
  options.run.lidar.columns = 90;
  options.run.lidar.max_range = 20.0;
  const SimulatedRun run(options.run, MakeVineyard(options));
  const Trajectory3 truth = ReadTrajectory((folder_ / "bin/ground_truth.tum").string());
  ASSERT_EQ(truth.poses.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(truth.poses[i].stamp, run.Middle(i), 1e-9);
    EXPECT_LT((truth.poses[i].position - run.TruePose(i).translation()).norm(), 1e-8);
    const LidarSweep sweep = ReadKittiBin((folder_ / "bin/clouds" / ("00000" + std::to_string(i) + ".bin")).string());
    EXPECT_EQ(sweep.points, run.Sweep(i).points);
  }
  const GridImage map = ReadMapServer((folder_ / "bin/gt_map.yaml").string());
  EXPECT_EQ(map.occupancy, run.Map().occupancy);

  ASSERT_EQ(Run("--scenario vineyard --seed 5 --format pcd" + small + "pcd").exit_code, 0);
  const PointCloudFile cloud = ReadPointCloudFile((folder_ / "pcd/clouds/000001.pcd").string());
  EXPECT_EQ(cloud.sweep.points, run.Sweep(1).points);
  ASSERT_EQ(cloud.raw_times.size(), cloud.sweep.points.size());
  EXPECT_EQ(static_cast<float>(cloud.raw_times.back()), run.Sweep(1).times.back());
  EXPECT_EQ(Contents("pcd/ground_truth.tum"), Contents("bin/ground_truth.tum"));
}

TEST_F(SimulateTest, EqualOptionsGiveEqualBytesInEveryScenario) {
  for (const std::string name : {"cones", "citrus", "vineyard", "orchard", "forest"}) {
    const std::string small =
        " --scans 2 --quiet --set " + name + ".columns=90 " + name + ".max_range=15 --output DIR/";
    ASSERT_EQ(Run("--scenario " + name + small + name + "1").exit_code, 0);
    ASSERT_EQ(
        Run("--scenario " + name + " --config DIR/" + name + "1/simulation.yaml --quiet --output DIR/" + name + "2")
            .exit_code,
        0);
    ASSERT_EQ(Run("--scenario " + name + " --seed 2" + small + name + "3").exit_code, 0);
    for (const char* file : {"clouds/000001.bin", "ground_truth.tum", "gt_map.pgm", "controls.csv"}) {
      EXPECT_EQ(Contents(fs::path(name + "1") / file), Contents(fs::path(name + "2") / file)) << name << " " << file;
      EXPECT_NE(Contents(fs::path(name + "1") / file), Contents(fs::path(name + "3") / file)) << name << " " << file;
    }
    EXPECT_EQ(Contents(name + "1/simulation.yaml"), Contents(name + "2/simulation.yaml"));
  }
}

TEST_F(SimulateTest, MixesNoTwoRecordings) {
  const std::string small = "--scenario cones --quiet --set cones.columns=36 cones.max_range=15 --output DIR/out ";
  ASSERT_EQ(Run(small + "--scans 4").exit_code, 0);
  // The same again, and a longer one, replace it.
  EXPECT_EQ(Run(small + "--scans 4").exit_code, 0);
  EXPECT_EQ(Run(small + "--scans 5").exit_code, 0);
  const ProgramResult shorter = Run(small + "--scans 3");
  EXPECT_EQ(shorter.exit_code, 1);
  EXPECT_NE(shorter.output.find("does not belong to this recording"), std::string::npos) << shorter.output;
  EXPECT_EQ(Run(small + "--scans 5 --format pcd").exit_code, 1);
}

TEST_F(SimulateTest, RefusesWhatItCannotDo) {
  ExpectError("--output DIR/out", 2, "--scenario NAME is missing");
  ExpectError("--scenario forrest --output DIR/out", 2, "--scenario is 'forrest'; did you mean 'forest'?");
  ExpectError("--scenario forrest --output DIR/out", 2,
              "The scenarios are: cones, citrus, vineyard, orchard, forest, planar_orchard");
  ExpectError("--scenario planar_orchard", 2, "--output DIR is missing");
  ExpectError("--scenario planar_orchard --output DIR/out --format pcd", 2, "--format is for sweeps");
  const std::string cones = "--scenario cones --output DIR/out ";
  ExpectError(cones + "--format ply", 2, "--format is 'ply' but must be bin or pcd");
  ExpectError(cones + "--seed one", 2, "--seed");
  ExpectError(cones + "--seed -3", 2, "--seed is -3 but must be 0 or more");
  ExpectError(cones + "--scans 2000000", 1, "num_scans is 2000000, must lie in [0, 1000000]");
  ExpectError(cones + "--set cones.motion=fly", 1, "motion is 'fly', must be wheeled, trot or handheld");
  ExpectError(cones + "--set cones.cone=3", 1, "did you mean 'cones'?");
  ExpectError(cones + "--set forest.stems=3", 1, "unknown section 'forest'");
  const std::string valid = "--scenario planar_orchard --output DIR/out ";
  ExpectError(valid + "--seed -1", 2, "--seed is -1 but must be 0 or more");
  ExpectError(valid + "--scans 0", 2, "--scans is 0 but must be 1 or more");
  ExpectError(valid + "--scan 3", 2, "--scans");
  ExpectError(valid + "--set planar_orchard.row=3", 1, "did you mean 'rows'?");
  ExpectError(valid + "--set planar_orchard.rows=1", 1, "rows is 1, must lie in [2, 200]");
  ExpectError(valid + "--config DIR/none.yaml", 1, "none.yaml: no such configuration file");
  ExpectError(valid + "--scans 2000000000", 1, "2000000000 scans are too many for one file");
  std::ofstream(folder_ / "file") << "x";
  ExpectError("--scenario planar_orchard --scans 2 --output DIR/file", 1, "cannot be made a folder");
  ExpectError("--scenario planar_orchard --scans 2 --output DIR/file/out", 1, "cannot be made a folder");
}

TEST_F(SimulateTest, HelpIsShortAndNamesEveryFlag) {
  const ProgramResult result = Run("--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* flag : {"--scenario", "--output", "--format", "--seed", "--scans", "--config", "--set", "--quiet"}) {
    EXPECT_NE(result.output.find(flag), std::string::npos) << flag;
  }
  EXPECT_LT(std::count(result.output.begin(), result.output.end(), '\n'), 32);
}

}  // namespace
}  // namespace arborslam
