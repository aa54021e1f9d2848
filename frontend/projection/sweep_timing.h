#ifndef ARBORSLAM_FRONTEND_PROJECTION_SWEEP_TIMING_H_
#define ARBORSLAM_FRONTEND_PROJECTION_SWEEP_TIMING_H_

#include <vector>

#include "core/sensor/lidar_sweep.h"

namespace arborslam {

/// When in the sweep each point was measured, as a share of its duration: 0 at its start, 1 at its end. From `times` if
/// the sweep has them (those outside of it are taken for its start or end), else from the order of the points:
/// - column by column, as spinning lidars send them (one turn over the whole file, either way round, from any azimuth,
///   a little more or less than 360 deg): from the azimuth turned since the first point, one turn being the whole sweep
///   unless there is more;
/// - ring after ring, each a circle (or an arc) the same way round: from the azimuth turned since the one at which most
///   rings begin.
/// Azimuth is that about the sweep's `spin_axis`. It counts as time to within the sensor's azimuth offsets between
/// beams (some degrees in some sensors, that is, some hundredths of the sweep). Empty when there is nothing to go by:
/// no duration, a few points only, or an order that follows no turn. Such a sweep cannot be deskewed.
std::vector<float> PointPhases(const LidarSweep& sweep);

/// The same into `phases`, whose memory is used again.
void PointPhases(const LidarSweep& sweep, std::vector<float>* phases);

/// The points of a sweep in the frame whose z axis is its `spin_axis`, in which the returns of a column have one
/// azimuth.
std::vector<Eigen::Vector3f> PointsAboutSpinAxis(const LidarSweep& sweep);

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_SWEEP_TIMING_H_
