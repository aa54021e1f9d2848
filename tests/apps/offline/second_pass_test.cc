#include "apps/offline/second_pass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"

namespace arborslam {
namespace {

// Sweeps of one point, a quarter of a second apart, whose duration is a guess.
class GuessedSweeps : public ScanSource {
 public:
  std::optional<Scan> Next() override {
    if (next_ == 4) return std::nullopt;
    LidarSweep sweep;
    sweep.start = 100.0 + 0.25 * next_++;
    sweep.duration = 0.1;
    sweep.is_duration_guessed = true;
    sweep.points.emplace_back(1.0f, 0.0f, 0.0f);
    return sweep;
  }
  std::optional<size_t> NumScans() const override { return 4; }
  const std::vector<std::string>& Notices() const override { return notices_; }

 private:
  int next_ = 0;
  std::vector<std::string> notices_;
};

struct RecordedRun {
  std::vector<ScanResult> scans;
  Trajectory3 trajectory;
};

// The second scan was skipped, the third one not matched.
RecordedRun RunOf(double duration) {
  RecordedRun run;
  for (int i = 0; i < 4; ++i) {
    ScanResult result;
    result.stamp = 100.0 + 0.25 * i + 0.5 * duration;
    result.status = i == 1 ? ScanStatus::kSkipped : (i == 2 ? ScanStatus::kPredicted : ScanStatus::kMatched);
    run.scans.push_back(result);
    if (i == 1) continue;
    StampedPose3 pose;
    pose.stamp = result.stamp;
    pose.position.x() = i;
    run.trajectory.poses.push_back(pose);
  }
  return run;
}

TEST(VisitMatchedSweeps, GivesMatchedSweepsTheirPosesAndTheDurationThatWasFound) {
  for (const double seconds : {0.05, 0.1, 0.25}) {
    const RecordedRun run = RunOf(seconds);
    SweepDurationResult duration;
    duration.seconds = seconds;
    duration.stamp_shift = 0.5 * (seconds - 0.1);
    GuessedSweeps source;
    std::vector<double> places;
    const bool is_whole = VisitMatchedSweeps(
        &source, run.scans, duration, run.trajectory,
        [&](const PosedSweep& sweep) {
          places.push_back(sweep.pose.position.x());
          EXPECT_DOUBLE_EQ(sweep.sweep.duration, seconds);
          EXPECT_NEAR(sweep.sweep.start, 100.0 + 0.25 * sweep.pose.position.x(), 1e-9);
          EXPECT_EQ(sweep.num_matched, places.size() - 1);
        },
        [](size_t) { return true; });
    EXPECT_TRUE(is_whole);
    EXPECT_THAT(places, testing::ElementsAre(0.0, 3.0));
  }
}

TEST(VisitMatchedSweeps, RefusesAnotherRecordingAndStopsWhenTold) {
  RecordedRun run = RunOf(0.1);
  GuessedSweeps source;
  size_t num_visited = 0;
  const auto count = [&](const PosedSweep&) { ++num_visited; };
  EXPECT_FALSE(
      VisitMatchedSweeps(&source, run.scans, std::nullopt, run.trajectory, count, [](size_t i) { return i < 1; }));
  EXPECT_EQ(num_visited, 1u);
  run.scans[0].stamp += 1.0;
  GuessedSweeps other;
  EXPECT_THROW(VisitMatchedSweeps(&other, run.scans, std::nullopt, run.trajectory, count, [](size_t) { return true; }),
               UserError);
}

}  // namespace
}  // namespace arborslam
