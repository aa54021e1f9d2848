#include <filesystem>
#include <iostream>

#include "apps/common/output_folder.h"
#include "apps/offline/graph_export.h"
#include "apps/offline/map_picture.h"
#include "apps/session/commands.h"
#include "apps/session/loaded_session.h"
#include "backend/run_outputs.h"
#include "core/error.h"
#include "core/io/g2o.h"
#include "core/io/map_io.h"
#include "core/io/png.h"
#include "core/io/trajectory_io.h"

namespace arborslam {

int SessionExport(const std::string& path, const std::string& folder_name) {
  const LoadedSession session = LoadSession(path);
  const SessionContents& contents = session.contents;
  if (contents.keyframes.empty()) throw UserError(path, "holds no keyframes yet", "nothing was written");
  const std::filesystem::path folder =
      PrepareOutputFolder(folder_name, {"trajectory.tum", "graph.g2o", "map.yaml", "map.pgm", "map.png"}, {path});
  // A lidar in the plane is fine enough for the map that people look at; sweeps' finer one needs the recording.
  OccupancyGridOptions grid = session.options.slam.grid;
  if (contents.keyframes.front().scan.point_rays_are_free && session.options.map.resolution > 0.0) {
    grid.cell_size = session.options.map.resolution;
  }
  const GridImage map = ToGridImage(MapOf(contents.graph, contents.keyframes, grid));
  WriteTum((folder / "trajectory.tum").string(), Trajectory3Of(contents.graph, contents.scans));
  WriteG2o((folder / "graph.g2o").string(), ToG2o(contents.graph));
  WriteMapServer((folder / "map.yaml").string(), map);
  WritePng((folder / "map.png").string(), DrawMap(map, TrajectoryOf(contents.graph, contents.scans)));
  std::cout << "trajectory.tum, graph.g2o, map.yaml, map.pgm and map.png are in " << folder.string() << "\n";
  return 0;
}

}  // namespace arborslam
