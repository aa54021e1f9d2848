#include "frontend/projection/sweep_timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

struct Turn {
  double start = 180.0;   // [deg], azimuth.
  double extent = 360.0;  // [deg]
  double sense = -1.0;    // 1: counter-clockwise.
  double drop_out = 0.0;
  bool by_rings = false;
  int rings = 16;
  double stagger = 0.0;  // [deg], azimuth offset of every second ring.
};

struct TimedSweep {
  LidarSweep sweep;
  std::vector<float> phases;
};

// A world of things at all distances; every beam returns but for drop-outs.
TimedSweep MakeSweep(const Turn& turn) {
  constexpr int kColumns = 600;
  Random random(7);
  TimedSweep made;
  made.sweep.duration = 0.1;
  const auto add = [&](int column, int ring) {
    const double share = static_cast<double>(column) / (kColumns - 1);
    const double azimuth =
        DegToRad(turn.start + turn.sense * turn.extent * share + (ring % 2 == 0 ? 0.0 : turn.stagger));
    const double elevation = DegToRad(-15.0 + 30.0 * ring / (turn.rings - 1));
    const double range = random.Uniform(1.0, 30.0);
    if (random.Uniform() < turn.drop_out) return;
    made.sweep.points.emplace_back(static_cast<float>(range * std::cos(azimuth) * std::cos(elevation)),
                                   static_cast<float>(range * std::sin(azimuth) * std::cos(elevation)),
                                   static_cast<float>(range * std::sin(elevation)));
    made.phases.push_back(static_cast<float>(share));
  };
  if (turn.by_rings) {
    for (int ring = 0; ring < turn.rings; ++ring) {
      for (int column = 0; column < kColumns; ++column) add(column, ring);
    }
  } else {
    for (int column = 0; column < kColumns; ++column) {
      for (int ring = 0; ring < turn.rings; ++ring) add(column, ring);
    }
  }
  return made;
}

// The largest of the differences but for the `ignored` share of the largest.
float Error(const std::vector<float>& phases, const std::vector<float>& expected, double ignored = 0.0) {
  EXPECT_EQ(phases.size(), expected.size());
  if (phases.size() != expected.size() || phases.empty()) return 1.0f;
  std::vector<float> errors;
  for (size_t i = 0; i < phases.size(); ++i) {
    EXPECT_GE(phases[i], 0.0f);
    EXPECT_LE(phases[i], 1.0f);
    errors.push_back(std::abs(phases[i] - expected[i]));
  }
  std::sort(errors.begin(), errors.end());
  return errors[static_cast<size_t>((1.0 - ignored) * static_cast<double>(errors.size() - 1))];
}

TEST(SweepTimingTest, TimesGoBeforeOrder) {
  TimedSweep made = MakeSweep({});
  std::vector<float> expected;
  for (size_t i = 0; i < made.sweep.points.size(); ++i) {
    made.sweep.times.push_back(i == 5 ? 0.3f : 0.025f);
    expected.push_back(i == 5 ? 1.0f : 0.25f);
  }
  EXPECT_LT(Error(PointPhases(made.sweep), expected), 1e-6f);
}

TEST(SweepTimingTest, FindsStartAndSenseOfColumns) {
  for (const double sense : {-1.0, 1.0}) {
    for (const double start : {180.0, 0.0, -90.0, 37.0}) {
      Turn turn;
      turn.start = start;
      turn.sense = sense;
      const TimedSweep made = MakeSweep(turn);
      EXPECT_LT(Error(PointPhases(made.sweep), made.phases), 1e-3f) << "start " << start << " sense " << sense;
    }
  }
}

TEST(SweepTimingTest, ColumnsMayBeLessOrMoreThanATurn) {
  for (const double extent : {340.0, 375.0}) {
    Turn turn;
    turn.extent = extent;
    TimedSweep made = MakeSweep(turn);
    // A turn takes the whole sweep unless there is more.
    for (float& phase : made.phases) phase *= static_cast<float>(std::min(1.0, extent / 360.0));
    EXPECT_LT(Error(PointPhases(made.sweep), made.phases), 1e-3f) << extent;
  }
}

TEST(SweepTimingTest, ColumnsMayHaveGaps) {
  Turn turn;
  turn.drop_out = 0.6;
  TimedSweep made = MakeSweep(turn);
  EXPECT_LT(Error(PointPhases(made.sweep), made.phases), 0.005f);
  // Nothing at all in a seventh of the circle.
  TimedSweep gap;
  gap.sweep.duration = 0.1;
  for (size_t i = 0; i < made.phases.size(); ++i) {
    if (made.phases[i] > 0.4f && made.phases[i] < 0.55f) continue;
    gap.sweep.points.push_back(made.sweep.points[i]);
    gap.phases.push_back(made.phases[i]);
  }
  EXPECT_LT(Error(PointPhases(gap.sweep), gap.phases), 0.005f);
}

TEST(SweepTimingTest, BeamsOfAColumnMayPointAside) {
  Turn turn;
  turn.stagger = 3.0;
  const TimedSweep made = MakeSweep(turn);
  EXPECT_LT(Error(PointPhases(made.sweep), made.phases, 0.02), 0.02f);
}

TEST(SweepTimingTest, FindsStartAndSenseOfRings) {
  for (const double sense : {-1.0, 1.0}) {
    for (const double start : {180.0, 0.0, 100.0}) {
      for (const int rings : {16, 64}) {
        Turn turn;
        turn.start = start;
        turn.sense = sense;
        turn.rings = rings;
        turn.by_rings = true;
        turn.drop_out = 0.2;
        const TimedSweep made = MakeSweep(turn);
        // At the seam itself, the end may be taken for the start.
        EXPECT_LT(Error(PointPhases(made.sweep), made.phases, 0.03), 0.02f)
            << "start " << start << " sense " << sense << " rings " << rings;
      }
    }
  }
}

TEST(SweepTimingTest, RingsMayBeArcs) {
  Turn turn;
  turn.start = 45.0;
  turn.extent = 90.0;
  turn.by_rings = true;
  const TimedSweep made = MakeSweep(turn);
  const std::vector<float> phases = PointPhases(made.sweep);
  ASSERT_EQ(phases.size(), made.phases.size());
  // A quarter of the turn takes a quarter of the sweep: it runs the right way at the right speed, from wherever.
  for (size_t i = 1; i < 600; ++i) {
    const float step = phases[i] - phases[i - 1];
    EXPECT_NEAR(step - std::round(step), 0.25f / 599.0f, 1e-4f);
  }
}

TEST(SweepTimingTest, ShuffledPointsSayNothing) {
  for (const bool by_rings : {false, true}) {
    Turn turn;
    turn.by_rings = by_rings;
    TimedSweep made = MakeSweep(turn);
    Random random(3);
    for (size_t i = made.sweep.points.size(); i > 1; --i) {
      std::swap(made.sweep.points[i - 1], made.sweep.points[random.Bits() % i]);
    }
    EXPECT_TRUE(PointPhases(made.sweep).empty());
  }
}

TEST(SweepTimingTest, SmallSweepsSayNothing) {
  for (const size_t size : {0, 1, 2, 20}) {
    LidarSweep sweep;
    sweep.duration = 0.1;
    sweep.points.assign(size, Eigen::Vector3f(1.0f, 0.5f, 0.0f));
    EXPECT_TRUE(PointPhases(sweep).empty()) << size;
  }
  LidarSweep still = MakeSweep({}).sweep;
  still.duration = 0.0;
  EXPECT_TRUE(PointPhases(still).empty());
  LidarSweep same;
  same.duration = 0.1;
  same.points.assign(1000, Eigen::Vector3f(1.0f, 0.5f, 0.0f));
  EXPECT_TRUE(PointPhases(same).empty());
}

}  // namespace
}  // namespace arborslam
