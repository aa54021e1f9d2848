#include "core/geometry/enclosing_circle.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace arborslam {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// The corners of the convex hull (Andrew 1979); `points` become sorted.
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d>* points) {
  std::sort(points->begin(), points->end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Eigen::Vector2d> hull;
  const auto add = [&hull](const Eigen::Vector2d& point, size_t least) {
    while (hull.size() > least && Cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Eigen::Vector2d& point : *points) add(point, 1);
  const size_t lower = hull.size();
  for (size_t i = points->size() - 1; i-- > 0;) add((*points)[i], lower);
  return hull;
}

bool IsInside(const Circle& circle, const Eigen::Vector2d& point) {
  return (point - circle.center).norm() <= circle.radius * (1.0 + 1e-12);
}

Circle Around(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return {0.5 * (a + b), 0.5 * (a - b).norm()}; }

// Through three points, or around the two that lie farthest apart if they lie in line.
Circle Around(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d u = b - a;
  const Eigen::Vector2d v = c - a;
  const double twice = 2.0 * Cross(u, v);
  if (std::abs(twice) < 1e-12 * (u.squaredNorm() + v.squaredNorm())) {
    return std::max({Around(a, b), Around(a, c), Around(b, c)},
                    [](const Circle& left, const Circle& right) { return left.radius < right.radius; });
  }
  const Eigen::Vector2d center = a + Eigen::Vector2d(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                                                     u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
                                         twice;
  return {center, (center - a).norm()};
}

}  // namespace

Circle EnclosingCircle(std::vector<Eigen::Vector2d> points) {
  if (points.empty()) return {};
  const std::vector<Eigen::Vector2d> hull = ConvexHull(&points);
  // A point outside the circle of those before it lies on the circle of them all (Welzl 1991).
  Circle circle{hull[0], 0.0};
  for (size_t i = 1; i < hull.size(); ++i) {
    if (IsInside(circle, hull[i])) continue;
    circle = {hull[i], 0.0};
    for (size_t j = 0; j < i; ++j) {
      if (IsInside(circle, hull[j])) continue;
      circle = Around(hull[i], hull[j]);
      for (size_t k = 0; k < j; ++k) {
        if (!IsInside(circle, hull[k])) circle = Around(hull[i], hull[j], hull[k]);
      }
    }
  }
  return circle;
}

}  // namespace arborslam
