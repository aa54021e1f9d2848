#include "frontend/projection/compact_things.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/config/validation.h"

namespace arborslam {
namespace {

// [rad], between neighbouring beams of a coarse lidar.
constexpr float kBeamSpacing = 0.01f;
// [m], by which noise makes a thing deeper than it is.
constexpr float kDepthNoise = 0.12f;
// Things keep a greater share rather than that fewer points than this are left.
constexpr size_t kMinMatched = 50;

struct Thing {
  std::vector<size_t> points;
  size_t last;
};

// Runs of connected points: a point joins the thing whose latest point is nearest, and joins two that it connects.
std::vector<Thing> FindThings(const std::vector<Eigen::Vector2f>& points, float max_gap) {
  std::vector<Thing> things;
  std::vector<size_t> open;  // Things that may still go on.
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2f& p = points[i];
    const float gap = max_gap + kBeamSpacing * p.norm();
    size_t joined = std::numeric_limits<size_t>::max();
    size_t kept = 0;
    for (const size_t candidate : open) {
      Thing& thing = things[candidate];
      const Eigen::Vector2f& last = points[thing.last];
      const bool connected = (p - last).squaredNorm() <= gap * gap;
      // Too far to the side already: closed.
      const float side = last.x() * p.y() - last.y() * p.x();
      const float ahead = last.dot(p);
      const bool passed = std::abs(side) > 2.0f * gap * last.norm() || ahead < 0.0f;
      if (!connected && passed) continue;
      if (connected && joined == std::numeric_limits<size_t>::max()) {
        joined = candidate;
      } else if (connected) {
        Thing& target = things[joined];
        target.points.insert(target.points.end(), thing.points.begin(), thing.points.end());
        thing.points.clear();
        continue;
      }
      open[kept++] = candidate;
    }
    open.resize(kept);
    if (joined == std::numeric_limits<size_t>::max()) {
      open.push_back(things.size());
      things.push_back({{i}, i});
    } else {
      things[joined].points.push_back(i);
      things[joined].last = i;
    }
  }
  return things;
}

}  // namespace

std::string CompactThingOptions::Validate() const {
  if (!(max_width >= 0.0 && max_width <= 10.0)) return Violation("max_width", max_width, "lie in [0, 10] m");
  if (!(max_gap >= 0.0 && max_gap <= 2.0)) return Violation("max_gap", max_gap, "lie in [0, 2] m");
  if (!(max_share > 0.0 && max_share <= 1.0)) return Violation("max_share", max_share, "lie in (0, 1]");
  return "";
}

void CenterCompactThings(const CompactThingOptions& options, PlanarScan* scan) {
  if (!options.enabled) return;
  std::vector<Eigen::Vector2f>& points = scan->points;
  for (const Thing& thing : FindThings(points, static_cast<float>(options.max_gap))) {
    if (thing.points.size() < 2) continue;
    Eigen::Vector2f mean = Eigen::Vector2f::Zero();
    for (const size_t i : thing.points) mean += points[i];
    mean /= static_cast<float>(thing.points.size());
    const float range = mean.norm();
    if (!(range > 0.0f)) continue;
    const Eigen::Vector2f ahead = mean / range;
    const Eigen::Vector2f aside(-ahead.y(), ahead.x());
    Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::infinity());
    Eigen::Vector2f high = -low;
    for (const size_t i : thing.points) {
      const Eigen::Vector2f place(ahead.dot(points[i]), aside.dot(points[i]));
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    // Every point stands for a stretch of the width, the outer ones too.
    const auto count = static_cast<float>(thing.points.size());
    const float width = (high.y() - low.y()) * count / (count - 1.0f);
    const float radius = 0.5f * width;
    if (width > static_cast<float>(options.max_width) || high.x() - low.x() > radius + kDepthNoise) continue;
    const float middle = 0.5f * (low.y() + high.y());
    for (const size_t i : thing.points) {
      const float side = aside.dot(points[i]) - middle;
      points[i] += std::sqrt(std::max(0.0f, radius * radius - side * side)) * ahead;
    }
  }
}

std::vector<Eigen::Vector2f> ThinnedThings(const CompactThingOptions& options,
                                           const std::vector<Eigen::Vector2f>& points) {
  if (!options.enabled) return points;
  std::vector<Thing> things = FindThings(points, static_cast<float>(options.max_gap));
  // By bearing: where two parts were joined they are out of order.
  for (Thing& thing : things) std::sort(thing.points.begin(), thing.points.end());
  const auto is_wide = [&](const Thing& thing) {
    if (thing.points.empty()) return true;
    const Eigen::Vector2f breadth = points[thing.points.front()] - points[thing.points.back()];
    return breadth.norm() > static_cast<float>(options.max_width);
  };
  things.erase(std::remove_if(things.begin(), things.end(), is_wide), things.end());
  size_t most = 0;
  for (const Thing& thing : things) most = std::max(most, thing.points.size());
  const auto num_left = [&](size_t limit) {
    size_t sum = points.size();
    for (const Thing& thing : things) sum -= thing.points.size() - std::min(limit, thing.points.size());
    return sum;
  };
  while (static_cast<double>(most) > options.max_share * static_cast<double>(num_left(most)) &&
         num_left(most - 1) >= kMinMatched) {
    --most;
  }
  std::vector<bool> is_left_out(points.size(), false);
  for (const Thing& thing : things) {
    const size_t count = thing.points.size();
    for (size_t i = 0; i < count && count > most; ++i) {
      if ((i + 1) * most / count == i * most / count) is_left_out[thing.points[i]] = true;
    }
  }
  std::vector<Eigen::Vector2f> kept;
  kept.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    if (!is_left_out[i]) kept.push_back(points[i]);
  }
  return kept;
}

}  // namespace arborslam
