#include "core/io/scan_source.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/io/carmen.h"
#include "core/io/input_file.h"
#include "core/io/npz.h"
#include "core/io/pullally.h"
#include "core/io/sweep_folder.h"

namespace arborslam {
namespace {

constexpr char kSupported[] =
    "give a folder of 3D sweeps (*.bin as KITTI's, *.pcd or *.ply, in it or in clouds/, velodyne/ or "
    "velodyne_points/data/; with timestamps.txt), a NumPy zip (.npz) of planar scans ('scan0', 'time') or a CARMEN log "
    "(FLASER, ROBOTLASER1)";

// What lies in a folder, for a message: "2 folders, 3 .bag, 1 .txt", the most frequent kinds first.
std::string ContentsText(const std::string& path) {
  constexpr size_t kMaxKinds = 5;
  std::map<std::string, size_t> counts;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    const std::string extension = entry->path().extension().string();
    const bool is_folder = entry->is_directory(ignored);
    ++counts[is_folder ? "folders" : extension.empty() ? "files without an extension" : extension];
  }
  if (error) return "cannot be read: " + error.message();
  if (counts.empty()) return "is empty";
  std::vector<std::pair<size_t, std::string>> kinds;
  for (const auto& [kind, count] : counts) kinds.emplace_back(count, kind);
  std::stable_sort(kinds.begin(), kinds.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (size_t i = 0; i < std::min(kinds.size(), kMaxKinds); ++i) {
    text += (i > 0 ? ", " : "") + std::to_string(kinds[i].first) + " " + kinds[i].second;
  }
  return "holds " + text + (kinds.size() > kMaxKinds ? ", ..." : "");
}

}  // namespace

std::unique_ptr<ScanSource> OpenScanSource(const std::string& path, const SweepFolderOptions& options) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(path, ignored);
  if (!is_folder && HasZipMagic(path)) {
    if (const NpzFile file(path); !file.Has("scan0")) {
      throw UserError(path, "is a zip archive without scans (it holds " + file.KeyList() + ")", kSupported);
    }
    return std::make_unique<PullallyScanSource>(path);
  }
  if (CarmenScanSource::Recognises(path)) return std::make_unique<CarmenScanSource>(path);
  if (SweepFolder::Recognises(path)) return std::make_unique<SweepFolder>(path, options);
  throw UserError(path,
                  is_folder ? "is a folder without a recording of a known format (it " + ContentsText(path) + ")"
                            : "is of no known format",
                  kSupported);
}

}  // namespace arborslam
