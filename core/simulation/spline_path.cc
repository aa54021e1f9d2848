#include "core/simulation/spline_path.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/simulation/random.h"

namespace arborslam {
namespace {

constexpr uint64_t kWanderStream = 110;
constexpr double kWanderWavelengths[] = {23.0, 14.0, 9.0};  // [m], about.
constexpr size_t kFewestPoints = 4;

}  // namespace

SplinePath::SplinePath(const ClosedPath& path, double spacing, double wander, uint64_t seed) {
  const size_t num_points = std::max(kFewestPoints, static_cast<size_t>(std::round(path.Length() / spacing)));
  spacing_ = path.Length() / static_cast<double>(num_points);
  Random random(seed, kWanderStream);
  std::vector<Eigen::Vector2d> waves;  // Wave number [rad/m] and phase.
  for (const double wavelength : kWanderWavelengths) {
    // A whole number of waves: the path stays closed.
    const double waves_around = std::max(1.0, std::round(path.Length() / wavelength));
    waves.emplace_back(2.0 * kPi * waves_around / path.Length(), random.Uniform(-kPi, kPi));
  }
  for (size_t i = 0; i < num_points; ++i) {
    const double distance = spacing_ * static_cast<double>(i);
    double across = 0.0;
    for (const Eigen::Vector2d& wave : waves) {
      // None at the start.
      across += std::sin(wave.x() * distance + wave.y()) - std::sin(wave.y());
    }
    across *= 0.5 * wander / static_cast<double>(waves.size());
    points_.emplace_back(path.At(distance) * Eigen::Vector2d(0.0, across));
  }
}

SE2 SplinePath::At(double distance) const {
  const double steps = distance / spacing_;
  const double whole = std::floor(steps);
  const double u = steps - whole;
  const auto count = static_cast<int64_t>(points_.size());
  const int64_t first = ((static_cast<int64_t>(whole) - 1) % count + count) % count;
  const double v = 1.0 - u;
  const double weights[] = {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
                            (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0, u * u * u / 6.0};
  const double slopes[] = {-0.5 * v * v, 1.5 * u * u - 2.0 * u, -1.5 * v * v + 2.0 * v, 0.5 * u * u};
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d tangent = Eigen::Vector2d::Zero();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d& point = points_[static_cast<size_t>((first + i) % count)];
    position += weights[i] * point;
    tangent += slopes[i] * point;
  }
  return SE2(position.x(), position.y(), std::atan2(tangent.y(), tangent.x()));
}

}  // namespace arborslam
