#include "core/io/kitti_bin.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "core/io/atomic_file.h"
#include "core/io/input_file.h"
#include "core/io/sweep_points.h"

namespace arborslam {
namespace {

using Record = std::array<float, 4>;
static_assert(sizeof(Record) == 16);

constexpr size_t kRecordsAtOnce = 4096;

// The value that begins at `bytes`.
float ValueAt(const char* bytes, const BinLayout& layout) {
  std::array<char, 8> raw{};
  std::memcpy(raw.data(), bytes, layout.value_size);
  if (layout.is_big_endian) std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(layout.value_size));
  if (layout.value_size == sizeof(float)) {
    float value = 0.0f;
    std::memcpy(&value, raw.data(), sizeof(value));
    return value;
  }
  double value = 0.0;
  std::memcpy(&value, raw.data(), sizeof(value));
  return std::abs(value) <= std::numeric_limits<float>::max() ? static_cast<float>(value)
                                                              : std::numeric_limits<float>::infinity();
}

bool IsEmptyFile(const std::string& path) {
  struct stat status;
  return ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) && status.st_size == 0;
}

}  // namespace

LidarSweep ReadKittiBin(const std::string& path, const BinLayout& layout) {
  LidarSweep sweep;
  if (IsEmptyFile(path)) return sweep;
  std::ifstream stream = OpenInputFile(path);
  stream.seekg(0, std::ios::end);
  const auto size = static_cast<uint64_t>(stream.tellg());
  stream.seekg(0);
  const size_t point_size = layout.point_size();
  if (size % point_size != 0) {
    throw UserError(path,
                    "is " + std::to_string(size) + " bytes long, which is no multiple of " + std::to_string(point_size),
                    "give " + layout.Name() + " (x, y, z, ...) for each point, or check that it was copied completely");
  }
  size_t remaining = size / point_size;
  RequireSweepSize(path, remaining);
  sweep.points.reserve(remaining);
  std::vector<char> records(std::min(remaining, kRecordsAtOnce) * point_size);
  while (remaining > 0) {
    const size_t count = std::min(remaining, kRecordsAtOnce);
    if (!stream.read(records.data(), static_cast<std::streamsize>(count * point_size))) {
      throw UserError(path, "cannot be read to its end", "check the storage");
    }
    for (size_t i = 0; i < count; ++i) {
      const char* record = records.data() + i * point_size;
      AppendPoint(ValueAt(record, layout), ValueAt(record + layout.value_size, layout),
                  ValueAt(record + 2 * layout.value_size, layout), &sweep);
    }
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
