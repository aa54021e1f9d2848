#include "core/io/pullally.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/geometry/angles.h"
#include "core/io/scan_source.h"
#include "tests/core/io/handmade_zip.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

using Arrays = std::map<std::string, NpyArray>;

std::string ErrorOf(const Arrays& arrays) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), arrays);
  return UserErrorOf([&] { PullallyScanSource source(folder.File("a.npz")); });
}

TEST(PullallyScanSource, GivesTheScansInOrderWithStampsAndBearings) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), {{"scan0", {{2, 3}, {1, 2, kInfinity, 4, 5, 6}}}, {"time", {{2}, {10.5, 15.0}}}});
  const std::unique_ptr<ScanSource> source = OpenScanSource(folder.File("a.npz"));
  EXPECT_EQ(source->NumScans(), 2u);
  EXPECT_THAT(source->Notices(), ElementsAre());
  const std::optional<Scan> first_scan = source->Next();
  ASSERT_TRUE(first_scan);
  const auto* first = &std::get<LaserScan>(*first_scan);
  EXPECT_EQ(first->stamp, 10.5);
  EXPECT_THAT(first->ranges, ElementsAre(1.0f, 2.0f, std::numeric_limits<float>::infinity()));
  EXPECT_DOUBLE_EQ(first->Bearing(0), -kPi);
  EXPECT_DOUBLE_EQ(first->Bearing(1), -kPi / 2.0);
  EXPECT_DOUBLE_EQ(first->Bearing(2), 0.0);
  const std::optional<Scan> second_scan = source->Next();
  ASSERT_TRUE(second_scan);
  const auto* second = &std::get<LaserScan>(*second_scan);
  EXPECT_EQ(second->stamp, 15.0);
  EXPECT_THAT(second->ranges, ElementsAre(4.0f, 5.0f, 6.0f));
  EXPECT_FALSE(source->Next());
  EXPECT_FALSE(source->Next());
}

TEST(PullallyScanSource, ReadsNothingButScansAndStamps) {
  // Arrays derived from the ground truth that no reader could make sense of.
  const TempFolder folder;
  const std::string scans = HandmadeNpy(Dictionary("<f4", "False", "(1, 2)"), RawValues<float>({1.0f, 2.0f}));
  const std::string times = HandmadeNpy(Dictionary("<i8", "False", "(1, 1)"), RawValues<int64_t>({7}));
  const std::string path = folder.Write("a.npz", HandmadeZip({{"scan0.npy", scans, {}},
                                                              {"time.npy", times, {}},
                                                              {"gnss_rotated_c.npy", "damaged", {}},
                                                              {"u_var.npy", "damaged", {}},
                                                              {"angles.npy", "damaged", {}}}));
  PullallyScanSource source(path);
  EXPECT_EQ(std::get<LaserScan>(*source.Next()).stamp, 7.0);
}

TEST(PullallyScanSource, WithoutStampsTheScansAreOneSecondApartAndTheUserIsTold) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), {{"scan0", {{3, 2}, {1, 1, 1, 1, 1, 1}}}});
  PullallyScanSource source(folder.File("a.npz"));
  EXPECT_THAT(source.Notices(), ElementsAre(HasSubstr("'time'")));
  EXPECT_EQ(std::get<LaserScan>(*source.Next()).stamp, 0.0);
  EXPECT_EQ(std::get<LaserScan>(*source.Next()).stamp, 1.0);
  EXPECT_EQ(std::get<LaserScan>(*source.Next()).stamp, 2.0);
}

TEST(PullallyScanSource, RangesThatAreNoRangesAreNoReturnsAndCounted) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), {{"scan0", {{2, 3}, {kNaN, 2, -1, 1e300, -kInfinity, 0}}}, {"time", {{2}, {0, 1}}}});
  PullallyScanSource source(folder.File("a.npz"));
  EXPECT_THAT(source.Notices(), ElementsAre(HasSubstr("3 of the 6 ranges")));
  const std::vector<float> first = std::get<LaserScan>(*source.Next()).ranges;
  EXPECT_TRUE(std::isnan(first[0]));
  EXPECT_EQ(first[1], 2.0f);
  EXPECT_TRUE(std::isnan(first[2]));
  const std::vector<float> second = std::get<LaserScan>(*source.Next()).ranges;
  EXPECT_TRUE(std::isinf(second[0]));
  EXPECT_TRUE(std::isnan(second[1]));
  EXPECT_EQ(second[2], 0.0f);
}

TEST(PullallyScanSource, StampsThatDoNotIncreaseAreTold) {
  const TempFolder folder;
  WriteNpz(folder.File("a.npz"), {{"scan0", {{4, 2}, std::vector<double>(8, 1.0)}}, {"time", {{4}, {0, 2, 2, 1}}}});
  EXPECT_THAT(PullallyScanSource(folder.File("a.npz")).Notices(), ElementsAre(HasSubstr("2 of the 4 stamps")));
}

TEST(PullallyScanSource, WrongArraysAreErrors) {
  const NpyArray scans{{2, 2}, {1, 1, 1, 1}};
  EXPECT_THAT(ErrorOf({{"scan0", {{4}, {1, 1, 1, 1}}}}),
              AllOf(HasSubstr("a.npz, array 'scan0'"), HasSubstr("(4,)"), HasSubstr("(scans, beams)")));
  EXPECT_THAT(ErrorOf({{"scan0", {{1, 2, 2}, {1, 1, 1, 1}}}}), HasSubstr("(1, 2, 2)"));
  EXPECT_THAT(ErrorOf({{"scan0", {{4, 1}, {1, 1, 1, 1}}}}), HasSubstr("(4, 1)"));
  EXPECT_THAT(ErrorOf({{"scan0", {{0, 897}, {}}}}), HasSubstr("(0, 897)"));
  EXPECT_THAT(ErrorOf({{"scan0", {{}, {1}}}}), HasSubstr("()"));
  EXPECT_THAT(ErrorOf({{"time", {{1}, {1}}}}), HasSubstr("no array 'scan0'"));
  EXPECT_THAT(ErrorOf({{"scan0", scans}, {"time", {{3}, {1, 2, 3}}}}),
              AllOf(HasSubstr("array 'time'"), HasSubstr("(3,)"), HasSubstr("2 records")));
  EXPECT_THAT(ErrorOf({{"scan0", scans}, {"time", {{1, 2}, {1, 2}}}}), HasSubstr("(1, 2)"));
  EXPECT_THAT(ErrorOf({{"scan0", scans}, {"time", {{}, {1}}}}), HasSubstr("()"));
}

TEST(PullallyScanSource, WrongElementTypeIsAnError) {
  const TempFolder folder;
  const std::string scans = HandmadeNpy(Dictionary("<c16", "False", "(1, 2)"), std::string(32, '\0'));
  const std::string path = folder.Write("a.npz", HandmadeZip({{"scan0.npy", scans, {}}}));
  EXPECT_THAT(UserErrorOf([&] { PullallyScanSource source(path); }), AllOf(HasSubstr("scan0"), HasSubstr("'<c16'")));
}

TEST(RecordedPullally, HasTheScansItsAuthorsPublished) {
  const std::pair<std::string, size_t> recordings[] = {{"p_v2_d1.npz", 546}, {"p_v2_d2.npz", 555}};
  for (const auto& [name, num_scans] : recordings) {
    const std::string path = DataFolder() + "/pullally/" + name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set ARBORSLAM_DATA";
    const std::unique_ptr<ScanSource> source = OpenScanSource(path);
    EXPECT_EQ(source->NumScans(), num_scans);
    EXPECT_THAT(source->Notices(), ElementsAre());
    size_t count = 0;
    size_t num_returns = 0;
    double stamp = -kInfinity;
    while (const std::optional<Scan> next = source->Next()) {
      const auto* scan = &std::get<LaserScan>(*next);
      ASSERT_EQ(scan->ranges.size(), 897u);
      EXPECT_NEAR(scan->bearing_increment, 2.0 * kPi / 898.0, 1e-12);
      EXPECT_GT(scan->stamp, stamp);
      stamp = scan->stamp;
      for (const float range : scan->ranges) {
        EXPECT_GT(range, 0.0f);
        num_returns += std::isfinite(range) ? 1 : 0;
      }
      ++count;
    }
    EXPECT_EQ(count, num_scans);
    EXPECT_GT(num_returns, 100 * num_scans);
  }
}

}  // namespace
}  // namespace arborslam
