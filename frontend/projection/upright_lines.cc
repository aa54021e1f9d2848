#include "frontend/projection/upright_lines.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"

namespace arborslam {
namespace {

constexpr float kMinRange = 0.7f;    // [m]
constexpr float kMaxRange = 12.0f;   // [m], farther off too few rings meet a trunk.
constexpr float kMinHeight = 0.25f;  // [m], above grass.
constexpr float kGap = 0.12f;        // [m], in range, between neighbouring returns of a line at most.
constexpr float kMinExtent = 0.4f;   // [m], of height.
constexpr float kMaxSpread = 0.05f;  // [m], RMS of the returns about the line.
constexpr float kMaxSlope = 0.35f;
constexpr size_t kMinReturns = 3;

struct Return {
  uint32_t column;
  float range;
  float z;
  float x;
  float y;
};

}  // namespace

std::vector<UprightLine> FindUprightLines(const PreparedSweep& sweep, const Eigen::Matrix3f& R_base_lidar) {
  std::vector<Return> returns;
  const float inverse_width = 1.0f / sweep.column_width;
  for (size_t i = 0; i < sweep.points.size(); ++i) {
    const float height = sweep.heights[i];
    if (!(height >= kMinHeight && height <= sweep.mean_canopy_height)) continue;
    const Eigen::Vector3f p = R_base_lidar * sweep.points[i];
    const float range = p.head<2>().norm();
    if (range < kMinRange || range > kMaxRange) continue;
    const float bearing = FastAtan2(p.y(), p.x()) + static_cast<float>(kPi);
    returns.push_back({static_cast<uint32_t>(bearing * inverse_width), range, p.z(), p.x(), p.y()});
  }
  std::sort(returns.begin(), returns.end(), [](const Return& a, const Return& b) {
    return a.column != b.column ? a.column < b.column : a.range < b.range;
  });
  std::vector<UprightLine> lines;
  for (size_t begin = 0; begin < returns.size();) {
    size_t end = begin + 1;
    while (end < returns.size() && returns[end].column == returns[begin].column &&
           returns[end].range - returns[end - 1].range <= kGap) {
      ++end;
    }
    const size_t first = begin;
    begin = end;
    const auto count = static_cast<float>(end - first);
    if (end - first < kMinReturns) continue;
    float mean_range = 0.0f;
    float mean_z = 0.0f;
    float low = returns[first].z;
    float high = low;
    for (size_t i = first; i < end; ++i) {
      mean_range += returns[i].range / count;
      mean_z += returns[i].z / count;
      low = std::min(low, returns[i].z);
      high = std::max(high, returns[i].z);
    }
    if (high - low < kMinExtent) continue;
    float rr = 0.0f;
    float rz = 0.0f;
    float zz = 0.0f;
    for (size_t i = first; i < end; ++i) {
      const float r = returns[i].range - mean_range;
      const float z = returns[i].z - mean_z;
      rr += r * r;
      rz += r * z;
      zz += z * z;
    }
    const float slope = rz / zz;
    const float rest = std::max(0.0f, rr - slope * rz);
    if (std::abs(slope) > kMaxSlope || rest > count * kMaxSpread * kMaxSpread) continue;
    const Eigen::Vector2f direction(returns[first].x, returns[first].y);
    lines.push_back({direction.normalized(), mean_range, slope, zz});
  }
  return lines;
}

}  // namespace arborslam
