#ifndef ARBORSLAM_CORE_STOPWATCH_H_
#define ARBORSLAM_CORE_STOPWATCH_H_

#include <chrono>

namespace arborslam {

/// Tells wall-clock time lap by lap.
class Stopwatch {
 public:
  /// [ms] since construction or the lap before.
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double milliseconds = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return milliseconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_STOPWATCH_H_
