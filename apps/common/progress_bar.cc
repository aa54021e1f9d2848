#include "apps/common/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace arborslam {
namespace {

constexpr double kMinInterval = 0.1;  // [s]
constexpr size_t kBarWidth = 20;
constexpr char kEraseLine[] = "\r\x1b[K";

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string Duration(double seconds) {
  const auto total = static_cast<long long>(std::min(std::ceil(seconds), 359999.0));
  char text[32];
  if (total >= 3600) {
    std::snprintf(text, sizeof(text), "%lld:%02lld:%02lld", total / 3600, total / 60 % 60, total % 60);
  } else {
    std::snprintf(text, sizeof(text), "%lld:%02lld", total / 60, total % 60);
  }
  return text;
}

}  // namespace

bool StderrIsTerminal() { return ::isatty(STDERR_FILENO) == 1; }

ProgressBar::ProgressBar(std::ostream& stream, std::optional<size_t> total, bool enabled)
    : ProgressBar(stream, total, enabled, &SteadySeconds) {}

ProgressBar::ProgressBar(std::ostream& stream, std::optional<size_t> total, bool enabled, Clock clock)
    : stream_(stream), total_(total), enabled_(enabled), clock_(std::move(clock)), start_(clock_()) {}

ProgressBar::~ProgressBar() { Clear(); }

void ProgressBar::Update(size_t num_done) {
  if (!enabled_) return;
  const double now = clock_();
  if (last_drawn_ && now - *last_drawn_ < kMinInterval) return;
  last_drawn_ = now;
  is_visible_ = true;
  stream_ << kEraseLine << Line(num_done, now - start_) << std::flush;
}

void ProgressBar::Clear() {
  if (!is_visible_) return;
  is_visible_ = false;
  last_drawn_.reset();
  stream_ << kEraseLine << std::flush;
}

std::string ProgressBar::Line(size_t num_done, double elapsed) const {
  const double rate = elapsed > 0.0 ? static_cast<double>(num_done) / elapsed : 0.0;
  char text[128];
  if (!total_ || *total_ == 0) {
    std::snprintf(text, sizeof(text), "%zu scans  %.1f scans/s", num_done, rate);
    return text;
  }
  // A recording can turn out longer than its header says.
  const double share = std::min(1.0, static_cast<double>(num_done) / static_cast<double>(*total_));
  const auto filled = static_cast<size_t>(share * kBarWidth);
  const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '.');
  const size_t remaining = *total_ - std::min(num_done, *total_);
  const std::string time_left = rate > 0.0 ? Duration(static_cast<double>(remaining) / rate) : "-";
  std::snprintf(text, sizeof(text), "[%s] %3d %%  %zu/%zu scans  %.1f scans/s  ETA %s", bar.c_str(),
                static_cast<int>(100.0 * share), num_done, *total_, rate, time_left.c_str());
  return text;
}

}  // namespace arborslam
