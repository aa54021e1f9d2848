// Feeds the reader of CARMEN logs with damaged ones, for libFuzzer: what it takes must be read to its end, scan by scan
// with rising stamps; what it refuses must be a `UserError`. Built with -DARBORSLAM_BUILD_FUZZERS=ON and clang.

#include <glog/logging.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <variant>

#include "core/error.h"
#include "core/io/carmen.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string path =
      (std::filesystem::temp_directory_path() / ("carmen_fuzz_" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  arborslam::CarmenScanSource::Recognises(path);
  try {
    arborslam::CarmenScanSource source(path);
    size_t num_scans = 0;
    while (const std::optional<arborslam::Scan> scan = source.Next()) {
      const auto& planar = std::get<arborslam::LaserScan>(*scan);
      CHECK(std::isfinite(planar.stamp));
      CHECK(!planar.ranges.empty());
      for (const float range : planar.ranges) CHECK(range >= 0.0f);
      if (planar.odometry) CHECK(planar.odometry->vector().allFinite());
      ++num_scans;
    }
    CHECK(source.NumScans() == num_scans);
  } catch (const arborslam::UserError&) {
    // Said to the user in one line.
  }
  return 0;
}
