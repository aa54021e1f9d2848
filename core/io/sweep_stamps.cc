#include "core/io/sweep_stamps.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/error.h"
#include "core/io/input_file.h"
#include "core/io/text_reader.h"

namespace arborslam {
namespace {

constexpr double kYear2000 = 946684800.0;   // [s] since 1970.
constexpr double kYear2100 = 4102444800.0;  // [s] since 1970.
constexpr double kLongestTurn = 0.21;       // [s], 5 Hz with some play.
constexpr double kUsualTurn = 0.1;          // [s]
constexpr size_t kMinFraction = 3;          // Digits; fewer may be a version or a counter.

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

bool IsInOurTime(double seconds) { return seconds >= kYear2000 && seconds <= kYear2100; }

template <typename T>
std::optional<T> ParseWhole(std::string_view text) {
  T value{};
  const std::from_chars_result result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

// Not by way of a double of the whole: it does not hold nanoseconds since 1970.
double Scaled(int64_t ticks, int64_t ticks_per_second) {
  return static_cast<double>(ticks / ticks_per_second) +
         static_cast<double>(ticks % ticks_per_second) / static_cast<double>(ticks_per_second);
}

// Days since 1970-01-01 in the Gregorian calendar (H. Hinnant, "chrono-compatible low-level date algorithms").
int DaysSince1970(int year, int month, int day) {
  year -= month <= 2 ? 1 : 0;
  const int era = (year >= 0 ? year : year - 399) / 400;
  const int year_of_era = year - era * 400;
  const int day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const int day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
  return era * 146097 + day_of_era - 719468;
}

// The numbers between two `separator`s each, exactly `N` of them and all of digits; the last may have a fraction.
template <size_t N>
std::optional<std::array<std::string_view, N>> Split(std::string_view text, char separator) {
  std::array<std::string_view, N> parts;
  for (size_t i = 0; i < N; ++i) {
    const size_t end = i + 1 < N ? text.find(separator) : text.size();
    if (end == std::string_view::npos || end == 0 || !IsDigit(text.front())) return std::nullopt;
    parts[i] = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

std::optional<double> ParseDateTime(std::string_view date, std::string_view time) {
  const auto date_parts = Split<3>(date, '-');
  const auto time_parts = Split<3>(time, ':');
  if (!date_parts || !time_parts) return std::nullopt;
  const std::optional<int> year = ParseWhole<int>((*date_parts)[0]);
  const std::optional<int> month = ParseWhole<int>((*date_parts)[1]);
  const std::optional<int> day = ParseWhole<int>((*date_parts)[2]);
  const std::optional<int> hour = ParseWhole<int>((*time_parts)[0]);
  const std::optional<int> minute = ParseWhole<int>((*time_parts)[1]);
  const std::optional<double> second = ParseWhole<double>((*time_parts)[2]);
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const bool is_valid = *year >= 1 && *year <= 9999 && *month >= 1 && *month <= 12 && *day >= 1 && *day <= 31 &&
                        *hour <= 24 && *minute <= 59 && *second < 61.0;  // A leap second has its own number.
  if (!is_valid) return std::nullopt;
  const int64_t whole = int64_t{86400} * DaysSince1970(*year, *month, *day) + 3600 * *hour + 60 * *minute;
  return static_cast<double>(whole) + *second;
}

// The stamp that `name`, which begins with a digit, is as a whole; see `StampsOfNames`.
std::optional<double> StampOfNumber(std::string_view name, bool since_1970_only) {
  const auto end = std::find_if_not(name.begin(), name.end(), IsDigit);
  const std::string_view whole = name.substr(0, static_cast<size_t>(end - name.begin()));
  const std::string_view rest = name.substr(whole.size());
  const std::string_view fraction = rest.empty() ? rest : rest.substr(1);
  if (!std::all_of(fraction.begin(), fraction.end(), IsDigit)) return std::nullopt;
  if (!rest.empty() && (rest.front() == '_' || rest.front() == '-')) {
    const std::optional<int64_t> seconds = ParseWhole<int64_t>(whole);
    const std::optional<int64_t> nanoseconds = ParseWhole<int64_t>(fraction);
    if (!seconds || !nanoseconds || *nanoseconds >= 1000000000) return std::nullopt;
    if (!IsInOurTime(static_cast<double>(*seconds))) return std::nullopt;
    return static_cast<double>(*seconds) + 1e-9 * static_cast<double>(*nanoseconds);
  }
  if (!rest.empty() && (rest.front() != '.' || fraction.empty())) return std::nullopt;
  const std::optional<double> stamp = ParseStamp(name);
  const bool is_stamp = stamp && (IsInOurTime(*stamp) || (!since_1970_only && fraction.size() >= kMinFraction));
  return is_stamp ? stamp : std::nullopt;
}

// The stamp that a file name ends with.
std::optional<double> StampOfName(std::string_view stem) {
  bool is_first = true;
  for (size_t i = 0; i < stem.size(); ++i) {
    if (!IsDigit(stem[i]) || (i > 0 && IsDigit(stem[i - 1]))) continue;
    if (const std::optional<double> stamp = StampOfNumber(stem.substr(i), !is_first)) return stamp;
    is_first = false;
  }
  return std::nullopt;
}

// How far the steps between `stamps` differ from their median, in the mean, as a share of it.
double Unevenness(std::vector<double> stamps) {
  std::sort(stamps.begin(), stamps.end());
  std::vector<double> steps;
  for (size_t i = 1; i < stamps.size(); ++i) steps.push_back(stamps[i] - stamps[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double median = *middle;
  double sum = 0.0;
  for (const double step : steps) sum += std::abs(step - median);
  return sum / (static_cast<double>(steps.size()) * std::max(median, 1e-9));
}

// The stamps of names that are seconds.nanoseconds without zeros in front of the nanoseconds, if these make the steps
// more even than `as_decimals` do; nothing if not.
std::optional<std::vector<double>> UnpaddedStamps(const std::vector<std::string>& stems,
                                                  const std::vector<double>& as_decimals) {
  constexpr size_t kMostDigits = 9;
  std::vector<double> stamps;
  size_t least = kMostDigits;
  for (const std::string& stem : stems) {
    const size_t point = stem.find_last_of('.');
    if (point == std::string::npos) return std::nullopt;
    const std::string_view fraction = std::string_view(stem).substr(point + 1);
    const std::optional<int64_t> nanoseconds = ParseWhole<int64_t>(fraction);
    if (!nanoseconds || fraction.size() > kMostDigits) return std::nullopt;
    least = std::min(least, fraction.size());
    const double whole = std::floor(as_decimals[stamps.size()]);
    stamps.push_back(whole + 1e-9 * static_cast<double>(*nanoseconds));
  }
  if (stamps.size() < 3 || least == kMostDigits) return std::nullopt;
  if (Unevenness(stamps) >= Unevenness(as_decimals)) return std::nullopt;
  return stamps;
}

}  // namespace

std::optional<double> ParseStamp(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  constexpr int64_t kTicksPerSecond[] = {1000, 1000000, 1000000000};
  if (const std::optional<int64_t> ticks = ParseWhole<int64_t>(text)) {
    for (const int64_t rate : kTicksPerSecond) {
      if (IsInOurTime(Scaled(*ticks, rate))) return Scaled(*ticks, rate);
    }
  }
  const std::optional<double> value = ParseWhole<double>(text);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  for (const int64_t rate : kTicksPerSecond) {
    if (IsInOurTime(*value / static_cast<double>(rate))) return *value / static_cast<double>(rate);
  }
  return value;
}

SweepStamps ReadSweepStamps(const std::string& path) {
  SweepStamps stamps;
  TextReader reader(path);
  while (reader.Next()) {
    const std::vector<std::string>& fields = reader.fields();
    std::optional<double> stamp;
    if (fields.size() == 1) stamp = ParseStamp(fields[0]);
    if (fields.size() == 2) stamp = ParseDateTime(fields[0], fields[1]);
    if (!stamp) {
      std::string line;
      for (const std::string& field : fields) line += (line.empty() ? "" : " ") + field;
      throw UserError(reader.Place(), Quoted(line) + " is no stamp",
                      "give one a line, in seconds or as '2011-09-26 13:02:25.964389445'");
    }
    stamps.seconds.push_back(*stamp);
    stamps.line_numbers.push_back(reader.line_number());
  }
  return stamps;
}

std::optional<std::vector<double>> StampsOfNames(const std::vector<std::string>& stems) {
  std::vector<double> stamps;
  stamps.reserve(stems.size());
  for (const std::string& stem : stems) {
    const std::optional<double> stamp = StampOfName(stem);
    if (!stamp) return std::nullopt;
    stamps.push_back(*stamp);
  }
  if (const std::optional<std::vector<double>> unpadded = UnpaddedStamps(stems, stamps)) stamps = *unpadded;
  std::vector<double> sorted = stamps;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return std::nullopt;
  return stamps;
}

SweepDuration SweepDurationFromStamps(const std::vector<double>& stamps) {
  std::vector<double> steps;
  for (size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
  }
  SweepDuration duration;
  duration.seconds = kUsualTurn;
  if (steps.empty()) return duration;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  duration.median_step = *middle;
  if (*middle > kLongestTurn) return duration;
  duration.seconds = *middle;
  duration.is_assumed = false;
  return duration;
}

}  // namespace arborslam
