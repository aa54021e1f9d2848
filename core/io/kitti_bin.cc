#include "core/io/kitti_bin.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/input_file.h"
#include "core/io/sweep_points.h"

namespace arborslam {
namespace {

using Record = std::array<float, 4>;
static_assert(sizeof(Record) == 16);

constexpr size_t kRecordsAtOnce = 4096;

bool IsEmptyFile(const std::string& path) {
  struct stat status;
  return ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) && status.st_size == 0;
}

}  // namespace

LidarSweep ReadKittiBin(const std::string& path) {
  LidarSweep sweep;
  if (IsEmptyFile(path)) return sweep;
  std::ifstream stream = OpenInputFile(path);
  stream.seekg(0, std::ios::end);
  const auto size = static_cast<uint64_t>(stream.tellg());
  stream.seekg(0);
  if (size % sizeof(Record) != 0) {
    throw UserError(path, "is " + std::to_string(size) + " bytes long, which is no multiple of 16",
                    "give 4 float32 (x, y, z, intensity) for each point, or check that it was copied completely");
  }
  size_t remaining = size / sizeof(Record);
  RequireSweepSize(path, remaining);
  sweep.points.reserve(remaining);
  std::vector<Record> records(std::min(remaining, kRecordsAtOnce));
  while (remaining > 0) {
    const size_t count = std::min(remaining, kRecordsAtOnce);
    if (!stream.read(reinterpret_cast<char*>(records.data()), static_cast<std::streamsize>(count * sizeof(Record)))) {
      throw UserError(path, "cannot be read to its end", "check the storage");
    }
    for (size_t i = 0; i < count; ++i) AppendPoint(records[i][0], records[i][1], records[i][2], &sweep);
    remaining -= count;
  }
  return sweep;
}

void WriteKittiBin(const std::string& path, const LidarSweep& sweep) {
  AtomicFile file(path);
  for (const Eigen::Vector3f& point : sweep.points) {
    const Record record = {point.x(), point.y(), point.z(), 0.0f};
    file.stream().write(reinterpret_cast<const char*>(record.data()), sizeof(record));
  }
  file.Commit();
}

}  // namespace arborslam
