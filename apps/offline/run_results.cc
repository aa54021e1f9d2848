#include "apps/offline/run_results.h"

#include <Eigen/Geometry>
#include <system_error>
#include <utility>

#include "apps/offline/graph_export.h"
#include "apps/offline/html_report.h"
#include "apps/offline/map_picture.h"
#include "backend/run_outputs.h"
#include "core/geometry/se2.h"
#include "core/io/atomic_file.h"
#include "core/io/ply.h"
#include "core/io/png.h"
#include "core/io/trajectory_io.h"
#include "core/map/height_colours.h"

namespace arborslam {
namespace {

constexpr char kCloudFile[] = "cloud.ply";

// What the score of a scan is held to.
std::vector<ScoreGate> ScoreGates(const SlamOptions& options) {
  return {{options.tracker.wide_score, "searched wide (tracker.wide_score)"},
          {options.tracker.max_insert_score, "kept out of the maps (tracker.max_insert_score)"},
          {options.matcher.max_score, "rejected (matcher.max_score)"}};
}

// `trajectory` seen from a frame in which its own lies at T_a_b.
Trajectory3 Moved(Trajectory3 trajectory, const SE2& T_a_b) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(T_a_b.theta(), Eigen::Vector3d::UnitZ()));
  for (StampedPose3& pose : trajectory.poses) {
    pose.position.head<2>() = T_a_b * Eigen::Vector2d(pose.position.head<2>());
    pose.orientation = turn * pose.orientation;
  }
  return trajectory;
}

}  // namespace

RunResults ResultsOf(const Slam& slam, const Trajectory3& odometry, double cell_size) {
  RunResults results;
  results.trajectory = slam.OptimizedTrajectory3();
  results.odometry = odometry;
  results.odometry_in_map = odometry;
  results.paths = {slam.OptimizedTrajectory()};
  results.graph = ToG2o(slam.graph());
  results.map = ToGridImage(slam.BuildMap(cell_size));
  return results;
}

RunResults ResultsOf(const SessionContents& joint, const Trajectory3& odometry, const SlamOptions& options,
                     double cell_size) {
  OccupancyGridOptions grid = options.grid;
  if (cell_size > 0.0) grid.cell_size = cell_size;
  std::vector<Trajectory3> trajectories = TrajectoriesOf(joint);
  RunResults results;
  for (const Trajectory3& trajectory : trajectories) results.paths.push_back(ToPlanar(trajectory));
  results.trajectory = std::move(trajectories.back());
  results.odometry = odometry;
  results.odometry_in_map =
      Moved(odometry, results.paths.back().front().pose * ToPlanar(odometry).front().pose.Inverse());
  results.graph = ToG2o(joint.graph);
  results.map = ToGridImage(MapOf(joint.graph, joint.keyframes, grid));
  return results;
}

void WriteResults(const std::filesystem::path& folder, const SlamOptions& options, const std::vector<Submap>& submaps,
                  const RunResults& results, const RunRecord& record, const std::string& effective_config) {
  WriteTum((folder / "trajectory.tum").string(), results.trajectory);
  WriteTum((folder / "odometry.tum").string(), results.odometry);
  WriteMapServer((folder / "map.yaml").string(), results.map);
  WritePng((folder / "map.png").string(), DrawMap(results.map, results.paths));
  if (results.cloud.empty()) {
    // An earlier run's would be taken for this one's.
    std::error_code error;
    std::filesystem::remove(folder / kCloudFile, error);
  } else {
    WritePly((folder / kCloudFile).string(), results.cloud, ColourByHeight(results.cloud));
  }
  WriteG2o((folder / "graph.g2o").string(), results.graph);
  WriteFileAtomically((folder / "effective_config.yaml").string(), effective_config);
  WriteFileAtomically((folder / "summary.json").string(), SummaryJson(record));
  const ReportInput report{record,
                           submaps,
                           effective_config,
                           &results.map,
                           results.trajectory,
                           results.odometry_in_map,
                           ScoreGates(options)};
  WriteFileAtomically((folder / "report.html").string(), HtmlReport(report));
}

}  // namespace arborslam
