#include "frontend/mounting/mounting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "core/geometry/angles.h"
#include "frontend/projection/fast_atan2.h"
#include "frontend/projection/ground_search.h"

namespace arborslam {
namespace {

constexpr float kMaxUsualTilt = static_cast<float>(DegToRad(20.0));  // Of a mounting.
constexpr float kMinUsualHeight = 0.1f;                              // [m]
constexpr float kMaxUsualHeight = 5.5f;                              // [m]
constexpr float kMaxSweepTilt = static_cast<float>(DegToRad(30.0));  // Of a lidar that leans with its robot.
constexpr float kMinOriginHeight = -1.0f;                            // [m], of the origin of a robot's frame.
constexpr float kMinUnusualScore = 0.12f;      // Treetops seen from above, or a hedge, do not reach it.
constexpr float kMaxUnusualBelowShare = 0.5f;  // Of returns below, over those on the plane.
constexpr float kOtherDirection = static_cast<float>(DegToRad(40.0));
constexpr float kMaxOtherScore = 0.7f;    // Of a plane in another direction, over that of the ground.
constexpr float kClearShare = 0.2f;       // Of returns on a plane that is no other's.
constexpr float kUsualScoreShare = 0.6f;  // Of the best plane's score.
constexpr float kMaxDisagreement = static_cast<float>(DegToRad(20.0));
constexpr float kMaxSnap = static_cast<float>(DegToRad(10.0));
constexpr float kSteep = static_cast<float>(DegToRad(20.0));  // Of the x axis, from the vertical.
constexpr float kMinBeamHeight = 0.2f;                        // [m], of a lidar over the ground.
constexpr float kBeamStep = 0.02f;                            // [m]
constexpr int kFineSteps = 10;                                // Of a step.
constexpr float kMinConeRange = 2.0f;                         // [m], nearer returns are on cones about another axis.
constexpr float kMaxConeRange = 20.0f;                        // [m]
constexpr float kMaxElevation = 0.8f;                         // [rad]
constexpr size_t kElevationBins = 800;
constexpr size_t kMaxConeReturns = 20000;
constexpr float kMinPeak = 3.0f;  // Over that at the origin, and over the median of all heights.

// The ground that one sweep shows.
GroundPlane GroundOf(const std::vector<Eigen::Vector3f>& points) {
  const GroundPlane any = SearchGround(points, GroundSearchRegion());
  const bool is_upright = any.normal.z() >= std::cos(kMaxSweepTilt) && any.height <= kMaxUsualHeight;
  if (any.ok && is_upright && any.share >= kClearShare && IsUsualTilt(any.normal)) return any;
  GroundSearchRegion region;
  region.max_tilt = kMaxSweepTilt;
  region.min_height = kMinUsualHeight;
  region.max_height = kMaxUsualHeight;
  const GroundPlane upright = SearchGround(points, region);
  // Points in the frame of the robot: that frame is upright.
  region.min_height = kMinOriginHeight;
  region.max_height = kMinUsualHeight;
  const GroundPlane low = SearchGround(points, region);
  const GroundPlane& best = low.ok && low.score > any.score ? low : any;
  const GroundPlane& ground = upright.ok && upright.score >= kUsualScoreShare * best.score ? upright : best;
  if (IsUsualTilt(ground.normal) && IsUsualHeight(ground.height)) return ground;
  const bool is_clear = ground.score >= kMinUnusualScore && ground.share_below <= kMaxUnusualBelowShare * ground.share;
  // Of several walls none is the ground.
  GroundSearchRegion elsewhere;
  elsewhere.up = ground.normal;
  elsewhere.min_tilt = kOtherDirection;
  const bool is_alone =
      is_clear && (IsUsualTilt(ground.normal) || SearchGround(points, elsewhere).score < kMaxOtherScore * ground.score);
  if (is_alone) return ground;
  return upright.ok && IsUsualTilt(upright.normal) ? upright : GroundPlane();
}

float Median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

MountingEstimate EstimateMounting(const std::vector<LidarSweep>& sweeps) {
  MountingEstimate mounting;
  mounting.num_sweeps = sweeps.size();
  std::vector<GroundPlane> planes;
  for (const LidarSweep& sweep : sweeps) {
    const GroundPlane plane = GroundOf(sweep.points);
    if (plane.ok) planes.push_back(plane);
  }
  const auto agrees = [](const GroundPlane& a, const GroundPlane& b) {
    return a.normal.dot(b.normal) >= std::cos(kMaxDisagreement);
  };
  const GroundPlane* centre = nullptr;
  for (const GroundPlane& plane : planes) {
    const auto num_agreeing = static_cast<size_t>(
        std::count_if(planes.begin(), planes.end(), [&](const GroundPlane& other) { return agrees(plane, other); }));
    if (num_agreeing <= mounting.num_agreeing) continue;
    mounting.num_agreeing = num_agreeing;
    centre = &plane;
  }
  mounting.ok = mounting.num_agreeing > 0 && 2 * mounting.num_agreeing >= sweeps.size();
  if (!mounting.ok) return mounting;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::vector<float> heights;
  for (const GroundPlane& plane : planes) {
    if (!agrees(*centre, plane)) continue;
    sum += plane.normal;
    heights.push_back(plane.height);
  }
  mounting.up = sum.normalized();
  mounting.height = Median(std::move(heights));
  return mounting;
}

bool IsUsualTilt(const Eigen::Vector3f& up) { return up.z() >= std::cos(kMaxUsualTilt); }

bool IsUsualHeight(float height) { return height >= kMinUsualHeight && height <= kMaxUsualHeight; }

Eigen::Vector3f SnappedToAxis(const Eigen::Vector3f& up) {
  Eigen::Index axis = 0;
  if (up.cwiseAbs().maxCoeff(&axis) < std::cos(kMaxSnap)) return up;
  return std::copysign(1.0f, up[axis]) * Eigen::Vector3f::Unit(axis);
}

bool KeepsHeadingOfX(const Eigen::Vector3f& up) { return std::abs(up.x()) <= std::cos(kSteep); }

Eigen::Matrix3f UprightRotation(const Eigen::Vector3f& up) {
  const Eigen::Vector3f y = KeepsHeadingOfX(up) ? up.cross(Eigen::Vector3f::UnitX()).normalized()
                                                : (Eigen::Vector3f::UnitY() - up.y() * up).normalized();
  Eigen::Matrix3f rotation;
  rotation.row(0) = y.cross(up);
  rotation.row(1) = y;
  rotation.row(2) = up;
  return rotation;
}

std::optional<float> BeamOriginHeight(const std::vector<LidarSweep>& sweeps, float origin_height) {
  std::vector<Eigen::Vector2f> returns;  // Range in the plane and z [m].
  size_t num_points = 0;
  for (const LidarSweep& sweep : sweeps) num_points += sweep.points.size();
  const size_t stride = std::max<size_t>(1, num_points / kMaxConeReturns);
  for (const LidarSweep& sweep : sweeps) {
    for (size_t i = 0; i < sweep.points.size(); i += stride) {
      const float range = sweep.points[i].head<2>().norm();
      if (range >= kMinConeRange && range <= kMaxConeRange) returns.emplace_back(range, sweep.points[i].z());
    }
  }
  // The sum of the squared numbers of returns at each elevation, seen from `height`.
  const auto peak_at = [&returns](float height) {
    std::array<float, kElevationBins> counts{};
    for (const Eigen::Vector2f& p : returns) {
      const float elevation = FastAtan2(p.y() - height, p.x());
      if (std::abs(elevation) >= kMaxElevation) continue;
      counts[static_cast<size_t>((elevation + kMaxElevation) * (0.5f / kMaxElevation) * kElevationBins)] += 1.0f;
    }
    float sum = 0.0f;
    for (const float count : counts) sum += count * count;
    return sum;
  };
  std::vector<float> peaks;
  float best = 0.0f;
  float best_peak = 0.0f;
  for (float height = kMinBeamHeight; height <= kMaxUsualHeight; height += kBeamStep) {
    peaks.push_back(peak_at(height - origin_height));
    if (peaks.back() <= best_peak) continue;
    best_peak = peaks.back();
    best = height - origin_height;
  }
  if (!(best_peak > kMinPeak * Median(peaks))) return std::nullopt;
  // Seen from an origin on the ground, the ground is a cone, too.
  if (origin_height >= kMinUsualHeight && !(best_peak > kMinPeak * peak_at(0.0f))) return std::nullopt;
  const float coarse = best;
  for (int i = -kFineSteps; i <= kFineSteps; ++i) {
    const float height = coarse + kBeamStep / kFineSteps * static_cast<float>(i);
    const float peak = peak_at(height);
    if (peak <= best_peak) continue;
    best_peak = peak;
    best = height;
  }
  return best;
}

std::string MountingText(const Eigen::Vector3f& up) {
  const Eigen::Matrix3f rotation = UprightRotation(up);
  const double pitch = std::asin(std::clamp(-static_cast<double>(rotation(2, 0)), -1.0, 1.0));
  const double roll = std::atan2(static_cast<double>(rotation(2, 1)), static_cast<double>(rotation(2, 2)));
  const double tilt = RadToDeg(std::acos(std::clamp(static_cast<double>(up.z()), -1.0, 1.0)));
  const char* const kind = tilt > 150.0 ? "upside down" : tilt > 70.0 && tilt < 110.0 ? "on its side" : "tilted";
  const long roll_deg = std::lround(RadToDeg(roll));
  std::array<char, 96> text;
  std::snprintf(text.data(), text.size(), "%s (roll %ld deg, pitch %ld deg)", kind, roll_deg == -180 ? 180 : roll_deg,
                std::lround(RadToDeg(pitch)));
  return text.data();
}

}  // namespace arborslam
