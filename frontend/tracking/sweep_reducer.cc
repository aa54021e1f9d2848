#include "frontend/tracking/sweep_reducer.h"

#include <glog/logging.h>

#include <cstddef>
#include <utility>

#include "frontend/tracking/terrain_fit.h"

namespace arborslam {
namespace {

// [m], farther off beams graze the ground: it says little more about the tilt, and much of it is grass.
constexpr float kMaxGroundRange = 10.0f;

// Moves the points of `scan` by what `change` adds to the robot's way between their moments and the middle of a sweep
// of `duration` [s].
void AddMotion(const PlanarVelocity& change, double duration, PlanarScan* scan) {
  for (size_t i = 0; i < scan->points.size(); ++i) {
    const double time = (static_cast<double>(scan->phases[i]) - 0.5) * duration;
    const SE2 motion(time * change.linear.x(), time * change.linear.y(), time * change.angular);
    scan->points[i] = (motion * Eigen::Vector2d(scan->points[i].cast<double>())).cast<float>();
  }
}

}  // namespace

SweepReducer::SweepReducer(const ReductionOptions& reduction, const SweepProjectionOptions& projection,
                           const MovingObjectOptions& moving_objects, const CompactThingOptions& compact,
                           double terrain_cell_size)
    : options_(reduction),
      compact_options_(compact),
      projector_(projection),
      moving_objects_(moving_objects),
      moving_object_options_(moving_objects),
      find_moving_(moving_objects.enabled),
      terrain_cell_size_(terrain_cell_size),
      terrain_(terrain_cell_size) {}

ReducedSweep SweepReducer::Reduce(const LidarSweep& sweep, const SE2& prediction, const PlanarVelocity& velocity) {
  const Eigen::Matrix3d R_lidar_base = last_tilt_.Rotation().transpose();
  ReducedSweep reduced;
  SweepMotion motion;
  if (options_.deskew) {
    motion.velocity = (R_lidar_base * Eigen::Vector3d(velocity.linear.x(), velocity.linear.y(), 0.0)).cast<float>();
    motion.angular_velocity = (R_lidar_base * Eigen::Vector3d(0.0, 0.0, velocity.angular)).cast<float>();
    reduced.deskewing = velocity;
  }
  prepared_ = projector_.Prepare(sweep, motion, std::move(prepared_));

  reduced.has_ground = prepared_.fit.ok;
  reduced.tilt = last_tilt_;
  if (prepared_.fit.ok) {
    for (const GroundSample& sample : prepared_.samples) {
      if (sample.position.head<2>().norm() <= kMaxGroundRange) reduced.ground.push_back(sample);
    }
    reduced.local_tilt = TiltFromUp(prepared_.fit.normal.cast<double>());
    reduced.local_tilt.z = prepared_.lidar_height;
    Tilt3 initial = reduced.local_tilt;
    if (!is_first_) initial.z = last_tilt_.z;
    reduced.tilt = FitToTerrain(reduced.ground, terrain_, prediction, initial).tilt;
    if (!options_.level && !is_first_) reduced.tilt = last_tilt_;
  }
  reduced.with_moving = projector_.Project(prepared_, reduced.tilt.Rotation().cast<float>());
  reduced.with_moving.stamp = sweep.Middle();
  reduced.planar = reduced.with_moving;
  if (find_moving_) {
    reduced.planar = WithoutMovingObjects(reduced.with_moving, moving_objects_.Find(reduced.with_moving, prediction));
  }
  reduced.num_moving = static_cast<int>(reduced.with_moving.points.size() - reduced.planar.points.size());
  CenterCompactThings(compact_options_, &reduced.planar);
  reduced.to_match = ThinnedThings(compact_options_, reduced.planar.points);
  return reduced;
}

bool SweepReducer::CanRedeskew(const ReducedSweep& reduced) const {
  return options_.deskew && !reduced.with_moving.phases.empty();
}

void SweepReducer::Redeskew(const LidarSweep& sweep, const PlanarVelocity& velocity, ReducedSweep* reduced) const {
  CHECK(CanRedeskew(*reduced));
  const PlanarVelocity change{velocity.linear - reduced->deskewing.linear,
                              velocity.angular - reduced->deskewing.angular};
  AddMotion(change, sweep.duration, &reduced->planar);
  AddMotion(change, sweep.duration, &reduced->with_moving);
  reduced->to_match = ThinnedThings(compact_options_, reduced->planar.points);
  reduced->deskewing = velocity;
}

void SweepReducer::ForgetPlace() {
  moving_objects_ = MovingObjectFilter(moving_object_options_);
  terrain_ = TerrainMap(terrain_cell_size_);
  is_first_ = true;
}

void SweepReducer::Commit(const ReducedSweep& sweep, const SE2& T_odom_base) {
  if (find_moving_) moving_objects_.Add(sweep.with_moving, T_odom_base);
  if (!sweep.has_ground) return;
  AddTerrain(sweep.ground, T_odom_base, sweep.tilt);
  last_tilt_ = sweep.tilt;
  is_first_ = false;
}

void SweepReducer::AddTerrain(const std::vector<GroundSample>& ground, const SE2& T_odom_base, const Tilt3& tilt) {
  const Eigen::Isometry3d T_odom_lidar = Lift(T_odom_base, tilt);
  for (const GroundSample& sample : ground) {
    terrain_.Insert(T_odom_lidar * sample.position.cast<double>(), sample.weight);
  }
}

}  // namespace arborslam
