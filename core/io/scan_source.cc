#include "core/io/scan_source.h"

#include <filesystem>
#include <system_error>

#include "core/error.h"
#include "core/io/input_file.h"
#include "core/io/npz.h"
#include "core/io/pullally.h"
#include "core/io/sweep_folder.h"

namespace arborslam {
namespace {

constexpr char kSupported[] =
    "give a recording of a supported kind: a folder of sweeps as KITTI .bin, with timestamps.txt, or a NumPy zip "
    "(.npz) "
    "with ranges 'scan0' and stamps 'time'";

}  // namespace

std::unique_ptr<ScanSource> OpenScanSource(const std::string& path, const SweepFolderOptions& options) {
  std::error_code ignored;
  if (SweepFolder::Recognises(path)) return std::make_unique<SweepFolder>(path, options);
  if (std::filesystem::is_directory(path, ignored)) {
    throw UserError(path, "is a folder without a recording of a known format", kSupported);
  }
  if (!HasZipMagic(path)) throw UserError(path, "is of no known format", kSupported);
  if (const NpzFile file(path); !file.Has("scan0")) {
    throw UserError(path, "is a zip archive without scans (it holds " + file.KeyList() + ")", kSupported);
  }
  return std::make_unique<PullallyScanSource>(path);
}

}  // namespace arborslam
