#include "core/io/stamp_repair.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/io/rising_stamps.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr double kYear2000 = 946684800.0;   // [s] since 1970.
constexpr double kYear2100 = 4102444800.0;  // [s] since 1970.
constexpr double kLongestStep = 60.0;       // [s], median step of any recording.
constexpr double kGreatestStamp = 1e12;     // [s]
constexpr double kLeastStep = 1e-6;         // [s]
// Of the steps, that run back when a clock was set back now and then; where more do, readings are at fault.
constexpr double kFewBackwards = 0.05;
// Of the stamps, that single wrong readings may be.
constexpr double kFewChanged = 0.2;
constexpr double kFewest = 3.0;  // At least.

// Share of whole numbers from which on stamps are counts of a unit.
constexpr double kMostlyWhole = 0.9;

struct Unit {
  double seconds;
  const char* name;
};
constexpr Unit kUnits[] = {{1.0, "seconds"}, {1e-3, "milliseconds"}, {1e-6, "microseconds"}, {1e-9, "nanoseconds"}};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> RisingSteps(const std::vector<double>& stamps) {
  std::vector<double> steps;
  for (size_t i = 1; i < stamps.size(); ++i) {
    const double step = stamps[i] - stamps[i - 1];
    if (step > 0.0 && std::isfinite(step)) steps.push_back(step);
  }
  return steps;
}

Unit UnitOf(const std::vector<double>& stamps) {
  std::vector<double> finite;
  std::copy_if(stamps.begin(), stamps.end(), std::back_inserter(finite), [](double s) { return std::isfinite(s); });
  if (finite.empty()) return kUnits[0];
  const double typical = Median(finite);
  for (const Unit& unit : kUnits) {
    if (typical * unit.seconds >= kYear2000 && typical * unit.seconds <= kYear2100) {
      // Nanoseconds of a few seconds since the start are no seconds since 1970: those would be hours apart.
      const std::vector<double> steps = RisingSteps(finite);
      if (steps.empty() || Median(steps) * unit.seconds <= 1e3 * kLongestStep) return unit;
    }
  }
  const auto num_whole = std::count_if(finite.begin(), finite.end(), [](double s) { return s == std::floor(s); });
  const bool are_whole = static_cast<double>(num_whole) >= kMostlyWhole * static_cast<double>(finite.size());
  const std::vector<double> steps = RisingSteps(finite);
  if (!are_whole || steps.empty()) return kUnits[0];
  for (const Unit& unit : kUnits) {
    if (Median(steps) * unit.seconds <= kLongestStep) return unit;
  }
  return kUnits[0];
}

// Nothing where the clock did not run back now and then; else the stamps with each piece moved behind the one before.
std::optional<std::vector<double>> MoveBehind(const std::vector<double>& stamps, size_t num_backwards) {
  const auto num_steps = static_cast<double>(stamps.size() - 1);
  if (static_cast<double>(num_backwards) > std::max(1.0, kFewBackwards * num_steps)) return std::nullopt;
  const double step = Median(RisingSteps(stamps));
  std::vector<double> moved{stamps[0]};
  for (size_t i = 1; i < stamps.size(); ++i) {
    const double taken = stamps[i] - stamps[i - 1];
    moved.push_back(moved.back() + (taken > 0.0 ? taken : step));
  }
  return moved;
}

// The stamps of `count` records of which those at `valid`, at least two, have `times`: between these spread evenly, and
// by the median step before and behind them.
std::vector<double> FilledUp(const std::vector<size_t>& valid, const std::vector<double>& times, size_t count) {
  const double step = Median(RisingSteps(times));
  std::vector<double> filled(count);
  size_t next = 0;  // The first of `valid` that is not before the record.
  for (size_t i = 0; i < count; ++i) {
    if (next < valid.size() && valid[next] < i) ++next;
    if (next == 0) {
      filled[i] = times[0] - step * static_cast<double>(valid[0] - i);
    } else if (next == valid.size()) {
      filled[i] = times.back() + step * static_cast<double>(i - valid.back());
    } else {
      const double share =
          static_cast<double>(i - valid[next - 1]) / static_cast<double>(valid[next] - valid[next - 1]);
      filled[i] = share < 1.0 ? times[next - 1] + share * (times[next] - times[next - 1]) : times[next];
    }
  }
  return filled;
}

// By how little stamps differ that are meant to be alike.
bool SayNothing(const std::vector<double>& stamps) {
  const std::vector<double> steps = RisingSteps(stamps);
  if (steps.empty()) return true;
  return Median(steps) < kLeastStep;
}

}  // namespace

RepairedStamps RepairStamps(std::vector<double> stamps, double usual_step) {
  RepairedStamps result;
  const size_t count = stamps.size();
  const auto note = [&result](const std::string& text) { result.notices.push_back(text); };
  const Unit unit = UnitOf(stamps);
  if (unit.seconds != 1.0) {
    const auto per_second = std::round(1.0 / unit.seconds);
    for (double& stamp : stamps) stamp /= per_second;
    note(std::string("The stamps are taken for ") + unit.name + ".");
  }
  std::vector<size_t> valid;
  std::vector<double> times;
  for (size_t i = 0; i < count; ++i) {
    if (!std::isfinite(stamps[i]) || std::abs(stamps[i]) > kGreatestStamp) continue;
    valid.push_back(i);
    times.push_back(stamps[i]);
  }
  if ((times.empty() && count > 0) || (count > 1 && (times.size() < 2 || SayNothing(times)))) {
    const double first = times.empty() ? 0.0 : times[0];
    for (size_t i = 0; i < count; ++i) result.seconds.push_back(first + usual_step * static_cast<double>(i));
    note("The stamps do not tell when the scans were taken; they are taken to be " + ShortestText(usual_step) +
         " s apart.");
    return result;
  }
  RisingStamps rising = MakeRising(times);
  std::optional<std::vector<double>> moved;
  const double few = std::max(kFewest, kFewChanged * static_cast<double>(times.size()));
  if (static_cast<double>(rising.num_changed) > few) {
    moved = MoveBehind(times, rising.num_backwards);
  }
  if (moved) {
    note("The clock of the stamps was set back " + std::to_string(rising.num_backwards) +
         " times; what follows is moved behind what came before.");
    times = *std::move(moved);
  } else if (rising.num_changed > 0) {
    note(std::to_string(rising.num_backwards) + " of the " + std::to_string(count) +
         " stamps are not later than the one before: " + std::to_string(rising.num_changed) +
         " are replaced by ones between their neighbours', and no scan is lost.");
    times = std::move(rising.stamps);
  }
  if (times.size() < count) {
    note(std::to_string(count - times.size()) + " of the " + std::to_string(count) +
         " stamps are no times; they are replaced by ones between their neighbours'.");
    times = FilledUp(valid, times, count);
  }
  result.seconds = std::move(times);
  return result;
}

}  // namespace arborslam
