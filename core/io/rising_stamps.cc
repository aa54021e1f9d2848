#include "core/io/rising_stamps.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace arborslam {
namespace {

constexpr size_t kNone = std::numeric_limits<size_t>::max();

// Indices of the longest strictly rising subsequence (Schensted 1961), ascending.
std::vector<size_t> LongestRising(const std::vector<double>& values) {
  std::vector<size_t> ends;  // ends[k]: where a rising sequence of length k + 1 ends that ends lowest.
  std::vector<size_t> before(values.size(), kNone);
  for (size_t i = 0; i < values.size(); ++i) {
    const auto place = std::lower_bound(ends.begin(), ends.end(), values[i],
                                        [&values](size_t end, double value) { return values[end] < value; });
    if (place != ends.begin()) before[i] = *(place - 1);
    if (place == ends.end()) {
      ends.push_back(i);
    } else {
      *place = i;
    }
  }
  std::vector<size_t> rising;
  for (size_t i = ends.empty() ? kNone : ends.back(); i != kNone; i = before[i]) rising.push_back(i);
  std::reverse(rising.begin(), rising.end());
  return rising;
}

// [s], between neighbours of which both are kept.
double MedianStep(const std::vector<double>& stamps, const std::vector<size_t>& kept) {
  std::vector<double> steps;
  for (size_t k = 1; k < kept.size(); ++k) {
    if (kept[k] == kept[k - 1] + 1) steps.push_back(stamps[kept[k]] - stamps[kept[k - 1]]);
  }
  if (steps.empty()) return 1.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

}  // namespace

RisingStamps MakeRising(std::vector<double> stamps) {
  RisingStamps result;
  // Sums and halves of steps below this are lost in a double, or one with another.
  constexpr double kLeastStep = 1e-6;
  for (size_t i = 1; i < stamps.size(); ++i) result.num_backwards += stamps[i] - stamps[i - 1] < kLeastStep ? 1 : 0;
  if (result.num_backwards > 0) {
    std::vector<double> tilted = stamps;
    for (size_t i = 0; i < tilted.size(); ++i) tilted[i] -= kLeastStep * static_cast<double>(i);
    const std::vector<size_t> kept = LongestRising(tilted);
    result.num_changed = stamps.size() - kept.size();
    const double step = MedianStep(stamps, kept);
    for (size_t i = kept.front(); i-- > 0;) stamps[i] = stamps[i + 1] - step;
    for (size_t i = kept.back() + 1; i < stamps.size(); ++i) stamps[i] = stamps[i - 1] + step;
    for (size_t k = 1; k < kept.size(); ++k) {
      const size_t first = kept[k - 1];
      const double spread = (stamps[kept[k]] - stamps[first]) / static_cast<double>(kept[k] - first);
      for (size_t i = first + 1; i < kept[k]; ++i) {
        stamps[i] = stamps[first] + spread * static_cast<double>(i - first);
      }
    }
  }
  result.stamps = std::move(stamps);
  return result;
}

}  // namespace arborslam
