#ifndef ARBORSLAM_APPS_OFFLINE_CLOUD_H_
#define ARBORSLAM_APPS_OFFLINE_CLOUD_H_

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "apps/offline/second_pass.h"
#include "core/map/cloud_options.h"
#include "core/map/voxel_map.h"

namespace arborslam {

/// The 3D map: sweeps, deskewed, at their final poses.
class Cloud {
 public:
  /// @param options valid ones.
  /// @param deskew  whether the motion during a sweep is taken out.
  Cloud(const CloudOptions& options, bool deskew);

  /// Takes a matched sweep if the options want it: those of clean keyframes, or every so many.
  void Add(const PosedSweep& sweep);

  /// Points [m, map frame] that enough sweeps met.
  std::vector<Eigen::Vector3f> Points() const { return map_.Points(options_.min_sweeps); }

  size_t num_sweeps() const { return num_sweeps_; }
  /// [m], above the one asked for if the map became too large.
  double voxel_size() const { return map_.voxel_size(); }

 private:
  CloudOptions options_;
  bool deskew_;
  VoxelMap map_;
  size_t num_sweeps_ = 0;
  // Of one sweep; their memory is used again.
  std::vector<float> phases_;
  std::vector<Eigen::Vector3f> points_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_CLOUD_H_
