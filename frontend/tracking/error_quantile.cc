#include "frontend/tracking/error_quantile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace arborslam {
namespace {

constexpr size_t kMemory = 200;    // Errors that count.
constexpr size_t kMinErrors = 30;  // Fewer tell nothing.
constexpr double kQuantile = 0.95;
constexpr double kNormalQuantile = 1.96;  // [standard deviations], of a normal error's amount.

}  // namespace

void ErrorQuantile::Add(double error) {
  amounts_.push_back(std::abs(error));
  if (amounts_.size() > kMemory) amounts_.pop_front();
}

std::optional<double> ErrorQuantile::Sigma(double safety) const {
  if (amounts_.size() < kMinErrors) return std::nullopt;
  std::vector<double> sorted(amounts_.begin(), amounts_.end());
  const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), nth, sorted.end());
  return safety * *nth / kNormalQuantile;
}

}  // namespace arborslam
