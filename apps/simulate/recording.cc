#include "apps/simulate/recording.h"

#include <array>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/map_io.h"
#include "core/io/trajectory_io.h"

namespace arborslam {
namespace {

void WriteBin(const std::string& path, const SimulatedSweep& sweep) {
  std::string bytes(sweep.sweep.points.size() * 16, '\0');
  char* to = bytes.data();
  for (size_t i = 0; i < sweep.sweep.points.size(); ++i, to += 16) {
    const Eigen::Vector3f& point = sweep.sweep.points[i];
    const std::array<float, 4> record = {point.x(), point.y(), point.z(), sweep.intensities[i]};
    std::memcpy(to, record.data(), 16);
  }
  WriteFileAtomically(path, bytes);
}

template <typename... Values>
std::string Line(const char* format, Values... values) {
  std::array<char, 256> line;
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

}  // namespace

void WriteRecording(const SimulatedRun& run, const std::filesystem::path& folder,
                    const std::function<void(size_t)>& progress) {
  const std::filesystem::path clouds = folder / "clouds";
  std::error_code error;
  std::filesystem::create_directories(clouds, error);
  if (!std::filesystem::is_directory(clouds)) {
    throw UserError(clouds.string(), "cannot be made a folder", "choose another --output");
  }
  WriteMapServer((folder / "gt_map.yaml").string(), run.Map());
  WriteTum((folder / "ground_truth.tum").string(), run.GroundTruth());
  std::string stamps;
  std::string controls = "stamp,forward_velocity,lateral_velocity,yaw_rate\n";
  for (size_t i = 0; i < run.NumScans(); ++i) {
    stamps += Line("%.9f\n", run.Start(i));
    const PlanarVelocity velocity = run.Control(i);
    controls += Line("%.9f,%.6f,%.6f,%.6f\n", run.Middle(i), velocity.forward, velocity.left, velocity.yaw);
  }
  WriteFileAtomically((folder / "timestamps.txt").string(), stamps);
  WriteFileAtomically((folder / "controls.csv").string(), controls);
  for (size_t i = 0; i < run.NumScans(); ++i) {
    WriteBin((clouds / Line("%06zu.bin", i)).string(), run.Sweep(i));
    progress(i + 1);
  }
}

}  // namespace arborslam
