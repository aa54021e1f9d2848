#include "apps/simulate/recording.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <string>
#include <system_error>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/kitti_bin.h"
#include "core/io/map_io.h"
#include "core/io/point_cloud_file.h"
#include "core/io/trajectory_io.h"

namespace arborslam {
namespace {

// Sweeps of an earlier recording beside those of this one would be taken for one recording.
void RefuseForeignFiles(const std::filesystem::path& clouds, size_t num_scans, const std::string& ending) {
  for (const auto& entry : std::filesystem::directory_iterator(clouds)) {
    const std::string stem = entry.path().stem().string();
    const bool is_number =
        stem.size() == 6 && std::all_of(stem.begin(), stem.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
    if (is_number && entry.path().extension() == ending && std::stoul(stem) < num_scans) continue;
    throw UserError(entry.path().string(), "does not belong to this recording",
                    "remove the folder " + clouds.string() + " or choose another --output");
  }
}

template <typename... Values>
std::string Line(const char* format, Values... values) {
  std::array<char, 256> line;
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

}  // namespace

void WriteRecording(const SimulatedRun& run, const std::filesystem::path& folder, SweepFormat format,
                    const std::function<void(size_t)>& progress) {
  const std::filesystem::path clouds = folder / "clouds";
  const std::string ending = format == SweepFormat::kBin ? ".bin" : ".pcd";
  std::error_code error;
  std::filesystem::create_directories(clouds, error);
  if (!std::filesystem::is_directory(clouds)) {
    throw UserError(clouds.string(), "cannot be made a folder", "choose another --output");
  }
  RefuseForeignFiles(clouds, run.NumScans(), ending);
  for (size_t i = 0; i < run.NumScans(); ++i) {
    const std::string path = (clouds / (Line("%06zu", i) + ending)).string();
    if (format == SweepFormat::kBin) {
      WriteKittiBin(path, run.Sweep(i));
    } else {
      WritePcd(path, run.Sweep(i));
    }
    progress(i + 1);
  }

  std::string stamps;
  std::string controls = "stamp,forward_velocity,lateral_velocity,yaw_rate\n";
  for (size_t i = 0; i < run.NumScans(); ++i) {
    stamps += Line("%.9f\n", run.Start(i));
    const OdometryVelocity velocity = run.Control(i);
    controls += Line("%.9f,%.6f,%.6f,%.6f\n", run.Middle(i), velocity.forward, velocity.left, velocity.yaw);
  }
  WriteFileAtomically((folder / "timestamps.txt").string(), stamps);
  WriteFileAtomically((folder / "controls.csv").string(), controls);
  WriteTum((folder / "ground_truth.tum").string(), run.GroundTruth());
  WriteMapServer((folder / "gt_map.yaml").string(), run.Map());
}

}  // namespace arborslam
