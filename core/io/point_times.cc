#include "core/io/point_times.h"

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

// Just below the square root of 1000, the step from unit to unit: the ranges of the units do not overlap.
constexpr double kSpanFactor = 31.6;

struct NamedUnit {
  double unit;
  const char* name;
};
constexpr NamedUnit kUnits[] = {
    {1.0, "seconds"}, {1e-3, "milliseconds"}, {1e-6, "microseconds"}, {1e-9, "nanoseconds"}};

}  // namespace

std::string PointTimeFormat::UnitName() const {
  const auto found =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const NamedUnit& named) { return named.unit == unit; });
  return found == std::end(kUnits) ? "" : found->name;
}

std::optional<PointTimeFormat> FindPointTimeFormat(const std::vector<double>& raw_times, double sweep_duration) {
  if (raw_times.empty()) return std::nullopt;
  const auto [min, max] = std::minmax_element(raw_times.begin(), raw_times.end());
  for (const NamedUnit& named : kUnits) {
    const double span = (*max - *min) * named.unit;
    if (!(span > sweep_duration / kSpanFactor && span < sweep_duration * kSpanFactor)) continue;
    PointTimeFormat format;
    format.unit = named.unit;
    const double reach = 2.0 * std::max(span, sweep_duration);
    format.is_absolute = std::max(std::abs(*min), std::abs(*max)) * named.unit > reach;
    return format;
  }
  return std::nullopt;
}

std::optional<PointTimeSpan> SpanOfPointTimes(const std::vector<double>& raw_times, const PointTimeFormat& format,
                                              double max_span) {
  if (raw_times.empty()) return std::nullopt;
  const auto [min, max] = std::minmax_element(raw_times.begin(), raw_times.end());
  const PointTimeSpan span{*min * format.unit, *max * format.unit};
  if (!(span.last - span.first <= max_span)) return std::nullopt;
  return span;
}

}  // namespace arborslam
