#ifndef ARBORSLAM_APPS_OFFLINE_RUN_RESULTS_H_
#define ARBORSLAM_APPS_OFFLINE_RUN_RESULTS_H_

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/offline/summary.h"
#include "backend/slam.h"
#include "backend/slam_options.h"
#include "backend/store/session_contents.h"
#include "core/io/g2o.h"
#include "core/io/map_io.h"
#include "core/map/submap.h"
#include "core/sensor/stamped_pose.h"
#include "core/sensor/trajectory3.h"

namespace arborslam {

/// What a run on a recording comes to.
struct RunResults {
  Trajectory3 trajectory;              ///< T_map_lidar of the recording's scans that have a pose, optimised.
  Trajectory3 odometry;                ///< T_odom_lidar of the same, as known when they came.
  Trajectory3 odometry_in_map;         ///< T_map_lidar likewise, beginning where the trajectory does.
  std::vector<Trajectory> paths;       ///< T_map_base of all recordings in the map, this one's last.
  PoseGraph2 graph;                    ///< Of all recordings in the map.
  GridImage map;                       ///< Likewise.
  std::vector<Eigen::Vector3f> cloud;  ///< [m], map frame; of this recording. Empty if there is none.
};

/// The results of a recording by itself, but for the cloud; `odometry` is its causal estimate.
/// @param cell_size [m] of the map; 0: that of the maps that scans are matched to.
RunResults ResultsOf(const Slam& slam, const Trajectory3& odometry, double cell_size);

/// The same of the last recording of a session of several.
RunResults ResultsOf(const SessionContents& joint, const Trajectory3& odometry, const SlamOptions& options,
                     double cell_size);

/// Writes all results but the session into `folder`, which exists; a 3D map of an earlier run is removed if there is
/// none now. Throws `UserError`.
/// @param submaps of the recording by itself, as `record` tells of it.
void WriteResults(const std::filesystem::path& folder, const SlamOptions& options, const std::vector<Submap>& submaps,
                  const RunResults& results, const RunRecord& record, const std::string& effective_config);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_RUN_RESULTS_H_
