#include "backend/run_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

namespace arborslam {
namespace {

using testing::HasSubstr;

std::vector<size_t> InOrder(size_t count) {
  std::vector<size_t> indices(count);
  std::iota(indices.begin(), indices.end(), size_t{0});
  return indices;
}

RunVerdict Judge(const std::vector<PoseSource>& sources, const std::vector<MapSegment>& segments) {
  return JudgeRun(sources, segments, InOrder(sources.size()));
}

TEST(RunVerdict, ARunThatWasTrackedThroughoutIsOk) {
  std::vector<PoseSource> sources(100, PoseSource::kMeasured);
  EXPECT_EQ(TextOf(Judge(sources, {{0, 99, true}})), "ok");
  sources[5] = sources[50] = PoseSource::kInterpolated;
  EXPECT_EQ(Judge(sources, {{0, 99, true}}).state, RunState::kOk);
}

TEST(RunVerdict, NamesWhatIsNotMeasured) {
  std::vector<PoseSource> sources(100, PoseSource::kMeasured);
  for (size_t i = 40; i < 43; ++i) sources[i] = PoseSource::kInterpolated;
  const RunVerdict verdict = Judge(sources, {{0, 99, true}});
  EXPECT_EQ(verdict.state, RunState::kDegraded);
  EXPECT_THAT(TextOf(verdict), HasSubstr("3 of 100 scans were not matched, most in a row scans 41 to 43"));
}

TEST(RunVerdict, TenInARowDegradeALongRun) {
  std::vector<PoseSource> sources(10000, PoseSource::kMeasured);
  for (size_t i = 500; i < 510; ++i) sources[i] = PoseSource::kInterpolated;
  EXPECT_EQ(Judge(sources, {{0, 9999, true}}).state, RunState::kDegraded);
  sources[505] = PoseSource::kMeasured;
  EXPECT_EQ(Judge(sources, {{0, 9999, true}}).state, RunState::kOk);
}

TEST(RunVerdict, LossIsSaidAlsoWhenItsSegmentsWereJoined) {
  const std::vector<PoseSource> sources(100, PoseSource::kMeasured);
  const RunVerdict joined = Judge(sources, {{0, 59, true}, {60, 99, true}});
  EXPECT_EQ(joined.state, RunState::kDegraded);
  EXPECT_THAT(TextOf(joined), HasSubstr("lost 1 times, first after scan 60; all segments were joined"));
  const RunVerdict apart = Judge(sources, {{0, 59, true}, {60, 99, false}});
  EXPECT_EQ(apart.state, RunState::kDegraded);
  EXPECT_THAT(TextOf(apart), HasSubstr("1 of 2 segments were not joined to the map (scans 61 to 100)"));
}

TEST(RunVerdict, ARunWithoutHalfOfItsScansInOneMapIsLost) {
  std::vector<PoseSource> sources(100, PoseSource::kMeasured);
  EXPECT_EQ(Judge(sources, {{0, 48, true}, {49, 99, false}}).state, RunState::kLost);
  for (size_t i = 49; i < 100; ++i) sources[i] = PoseSource::kUnknown;
  EXPECT_EQ(Judge(sources, {{0, 48, true}}).state, RunState::kLost);
}

TEST(RunVerdict, ScansApartOrUnknownAreNotPlaced) {
  const std::vector<PoseSource> sources = {PoseSource::kUnknown, PoseSource::kMeasured, PoseSource::kInterpolated,
                                           PoseSource::kMeasured, PoseSource::kMeasured};
  EXPECT_EQ(PlacedScans(sources, {{1, 3, true}, {4, 4, false}}), (std::vector<bool>{false, true, true, true, false}));
}

}  // namespace
}  // namespace arborslam
