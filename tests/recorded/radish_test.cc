// Bounds on the classic indoor logs with wheel odometry (RADISH). The relations are a reference here and never an
// input.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "backend/slam.h"
#include "core/config/config_schema.h"
#include "core/evaluation/relations.h"
#include "core/geometry/angles.h"
#include "core/io/scan_source.h"
#include "core/map/fine_map.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

class RadishTest : public testing::Test {
 protected:
  static std::string File(const std::string& name) { return DataFolder() + "/radish/" + name; }

  void SetUp() override {
    if (!std::filesystem::exists(File("aces.clf"))) {
      GTEST_SKIP() << File("aces.clf") << " is not here; set ARBORSLAM_DATA to the folder of the recorded data";
    }
  }

  static SlamOptions Preset() {
    SlamOptions options;
    FineMapOptions map;
    ConfigSchema schema;
    options.VisitSections([&schema](const std::string& name, auto& section) { schema.AddSection(name, &section); });
    schema.AddSection("map", &map);
    schema.LoadYamlFile(ARBORSLAM_SOURCE_DIR "/config/indoor2d.yaml");
    return options;
  }

  static RelationMetrics RunAces(const SlamOptions& options) {
    Slam slam(options, 2);
    const std::unique_ptr<ScanSource> source = OpenScanSource(File("aces.clf"));
    while (const std::optional<Scan> scan = source->Next()) slam.AddScan(std::get<LaserScan>(*scan));
    slam.Finish(false);
    const RelationMetrics metrics = EvaluateRelations(ToTrajectory3(slam.OptimizedTrajectory()),
                                                      ReadRelations(File("aces.relations")), 1e-3, "the recording");
    RecordProperty("translation_mean_m", std::to_string(metrics.translation_mean));
    RecordProperty("rotation_mean_deg", std::to_string(metrics.rotation_mean * 180.0 / kPi));
    return metrics;
  }
};

TEST_F(RadishTest, AcesWithThePreset) {
  const RelationMetrics metrics = RunAces(Preset());
  EXPECT_EQ(metrics.num_matched, metrics.num_relations);
  EXPECT_LE(metrics.translation_mean, 0.038);
  EXPECT_LE(metrics.translation_max, 0.5);
  EXPECT_LE(metrics.rotation_mean, 0.40 * kPi / 180.0);
}

TEST_F(RadishTest, NoScanOfIntelIsLostThoughStampsRunBackwards) {
  const std::unique_ptr<ScanSource> source = OpenScanSource(File("intel.clf"));
  EXPECT_EQ(source->NumScans(), 13631u);
  const auto& notices = source->Notices();
  EXPECT_TRUE(std::any_of(notices.begin(), notices.end(), [](const std::string& notice) {
    return notice.find("of the 13631 stamps are not later than the one before") != std::string::npos;
  }));
  size_t num_scans = 0;
  size_t num_no_return = 0;
  double last = -1.0;
  while (const std::optional<Scan> scan = source->Next()) {
    const auto& planar = std::get<LaserScan>(*scan);
    EXPECT_GT(planar.stamp, last);
    last = planar.stamp;
    EXPECT_TRUE(planar.odometry.has_value());
    num_no_return += static_cast<size_t>(
        std::count_if(planar.ranges.begin(), planar.ranges.end(), [](float range) { return std::isinf(range); }));
    ++num_scans;
  }
  EXPECT_EQ(num_scans, 13631u);
  EXPECT_EQ(num_no_return, 68313u);
}

}  // namespace
}  // namespace arborslam
