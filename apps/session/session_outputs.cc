#include "apps/session/session_outputs.h"

#include <cstddef>
#include <system_error>

#include "apps/offline/graph_export.h"
#include "apps/offline/map_picture.h"
#include "backend/run_outputs.h"
#include "core/io/g2o.h"
#include "core/io/map_io.h"
#include "core/io/png.h"
#include "core/io/trajectory_io.h"

namespace arborslam {
namespace {

constexpr char kOnlyTrajectory[] = "trajectory.tum";

std::string NthTrajectory(size_t index) { return "trajectory_" + std::to_string(index + 1) + ".tum"; }

// Trajectories of another number of recordings would be taken for this session's.
void RemoveOldTrajectories(const std::filesystem::path& folder, size_t num_recordings) {
  std::error_code ignored;
  if (num_recordings > 1) std::filesystem::remove(folder / kOnlyTrajectory, ignored);
  for (size_t i = num_recordings > 1 ? num_recordings : 0; std::filesystem::remove(folder / NthTrajectory(i), ignored);
       ++i) {
  }
}

}  // namespace

std::vector<std::string> SessionOutputNames(size_t num_recordings) {
  std::vector<std::string> names = {"graph.g2o", "map.yaml", "map.pgm", "map.png"};
  if (num_recordings == 1) names.emplace_back(kOnlyTrajectory);
  for (size_t i = 0; num_recordings > 1 && i < num_recordings; ++i) names.push_back(NthTrajectory(i));
  return names;
}

void WriteSessionOutputs(const std::filesystem::path& folder, const LoadedSession& session) {
  const SessionContents& contents = session.contents;
  // A lidar in the plane is fine enough for the map that people look at; sweeps' finer one needs the recording.
  OccupancyGridOptions grid = session.options.slam.grid;
  if (!IsSpatial(contents) && session.options.map.resolution > 0.0) {
    grid.cell_size = session.options.map.resolution;
  }
  const GridImage map = ToGridImage(MapOf(contents.graph, contents.keyframes, grid));

  const std::vector<Trajectory3> trajectories = TrajectoriesOf(contents);
  const size_t num_recordings = trajectories.size();
  std::vector<Trajectory> planar;
  for (size_t i = 0; i < num_recordings; ++i) {
    planar.push_back(ToPlanar(trajectories[i]));
    WriteTum((folder / (num_recordings > 1 ? NthTrajectory(i) : kOnlyTrajectory)).string(), trajectories[i]);
  }
  RemoveOldTrajectories(folder, num_recordings);
  WriteG2o((folder / "graph.g2o").string(), ToG2o(contents.graph));
  WriteMapServer((folder / "map.yaml").string(), map);
  WritePng((folder / "map.png").string(), DrawMap(map, planar));
}

}  // namespace arborslam
