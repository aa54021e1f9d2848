#include "apps/offline/footprints.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace arborslam {
namespace {

constexpr float kMaxRange = 8.0f;   // [m], farther returns are blurred by errors of the heading.
constexpr float kMaxHeight = 1.0f;  // [m], above the ground: crowns have no footprint.

}  // namespace

Footprints::Footprints(const GridImage& evidence, const FineMapOptions& options, const SlamOptions& slam_options)
    : options_(slam_options), map_(evidence, options), projector_(slam_options.sweep) {}

void Footprints::Add(const PosedSweep& sweep) {
  if (sweep.result.match.score > options_.tracker.max_insert_score) return;
  prepared_ =
      projector_.Prepare(sweep.sweep, options_.reduction.deskew ? sweep.motion : SweepMotion(), std::move(prepared_));
  if (!prepared_.fit.ok) return;
  const Eigen::Matrix3d R_map_lidar = sweep.pose.orientation.toRotationMatrix();
  const auto min_range = static_cast<float>(options_.sweep.min_range);
  const float max_range = std::min(kMaxRange, static_cast<float>(options_.sweep.max_range));
  const auto margin = static_cast<float>(options_.sweep.ground_margin);
  for (size_t i = 0; i < prepared_.points.size(); ++i) {
    const Eigen::Vector3f& point = prepared_.points[i];
    const float height = prepared_.heights[i];
    const float range = point.norm();
    if (!(height <= kMaxHeight && range >= min_range && range <= max_range)) continue;
    if (std::abs(std::atan2(point.y(), point.x())) > options_.sweep.max_bearing) continue;
    const Eigen::Vector3d position = R_map_lidar * point.cast<double>() + sweep.pose.position;
    if (height > margin) {
      map_.AddSolid(position.head<2>());
    } else {
      map_.AddGround(position.head<2>());
    }
  }
}

}  // namespace arborslam
