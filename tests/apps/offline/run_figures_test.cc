#include "apps/offline/run_figures.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace arborslam {
namespace {

ScanResult Scan(ScanStatus status, MatchVerdict verdict, double x = 0.0) {
  ScanResult scan;
  scan.status = status;
  scan.match.verdict = verdict;
  scan.T_odom_base = SE2(x, 0.0, 0.0);
  return scan;
}

TEST(PercentileTest, OfNoneOneAndMany) {
  EXPECT_EQ(Percentile({}, 0.5), 0.0);
  EXPECT_EQ(Percentile({7.0}, 0.95), 7.0);
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  EXPECT_EQ(Percentile(values, 0.0), 0.0);
  EXPECT_EQ(Percentile(values, 0.5), 50.0);
  EXPECT_EQ(Percentile(values, 0.95), 95.0);
  EXPECT_EQ(Percentile(values, 1.0), 100.0);
}

TEST(DegenerateStretchesTest, AreScansInARow) {
  RunRecord record;
  EXPECT_TRUE(DegenerateStretches(record).empty());
  const auto add = [&](MatchVerdict verdict, double x) {
    record.scans.push_back(Scan(ScanStatus::kMatched, verdict, x));
  };
  add(MatchVerdict::kDegenerate, 0.0);
  add(MatchVerdict::kDegenerate, 0.5);
  add(MatchVerdict::kDegenerate, 0.25);
  add(MatchVerdict::kAccepted, 2.0);
  add(MatchVerdict::kDegenerate, 3.0);
  // What has no pose has no match either.
  record.scans.push_back(Scan(ScanStatus::kSkipped, MatchVerdict::kDegenerate));
  add(MatchVerdict::kDegenerate, 4.0);
  const std::vector<DegenerateStretch> stretches = DegenerateStretches(record);
  ASSERT_EQ(stretches.size(), 3u);
  EXPECT_EQ(stretches[0].first, 0u);
  EXPECT_EQ(stretches[0].last, 2u);
  EXPECT_DOUBLE_EQ(stretches[0].length_m, 0.75);
  EXPECT_EQ(stretches[1].first, 4u);
  EXPECT_EQ(stretches[1].last, 4u);
  EXPECT_DOUBLE_EQ(stretches[1].length_m, 0.0);
  EXPECT_EQ(stretches[2].first, 6u);

  const nlohmann::json summary = nlohmann::json::parse(SummaryJson(record));
  ASSERT_EQ(summary.at("degenerate_stretches").size(), 3u);
  EXPECT_EQ(summary.at("degenerate_stretches").at(0).at("last_index"), 2);
}

TEST(CountRunTest, CountsEachKindOnce) {
  RunRecord record;
  record.scans.push_back(Scan(ScanStatus::kMatched, MatchVerdict::kAccepted));
  record.scans.push_back(Scan(ScanStatus::kMatched, MatchVerdict::kDegenerate));
  record.scans.push_back(Scan(ScanStatus::kPredicted, MatchVerdict::kPoor));
  record.scans.push_back(Scan(ScanStatus::kSkipped, MatchVerdict::kTooFewPoints));
  record.scans[0].is_keyframe = record.scans[1].is_keyframe = true;
  record.scans[0].is_inserted = true;
  record.scans[2].searched_wide = true;
  record.finish.loops.resize(3);
  record.finish.loops[1].accepted = true;
  const RunCounts counts = CountRun(record);
  EXPECT_EQ(counts.matched, 2u);
  EXPECT_EQ(counts.rejected, 1u);
  EXPECT_EQ(counts.skipped, 1u);
  EXPECT_EQ(counts.spoilt, 1u);
  EXPECT_EQ(counts.keyframes, 2u);
  EXPECT_EQ(counts.searched_wide, 1u);
  EXPECT_EQ(counts.degenerate, 1u);
  EXPECT_EQ(counts.loops_accepted, 1u);
}

TEST(OverPosedScansTest, LeavesOutWhatWasSkipped) {
  RunRecord record;
  record.scans.push_back(Scan(ScanStatus::kMatched, MatchVerdict::kAccepted));
  record.scans.push_back(Scan(ScanStatus::kSkipped, MatchVerdict::kAccepted));
  record.scans.push_back(Scan(ScanStatus::kPredicted, MatchVerdict::kPoor));
  for (ScanResult& scan : record.scans) {
    for (const StageField& field : StageFields()) scan.*field.time_ms = 2.0;
  }
  EXPECT_EQ(OverPosedScans(record, &ScanResult::match_ms), (std::vector<double>{2.0, 2.0}));
  const double all = 2.0 * static_cast<double>(StageFields().size());
  EXPECT_EQ(OverPosedScans(record, &TotalMs), (std::vector<double>{all, all}));
}

}  // namespace
}  // namespace arborslam
