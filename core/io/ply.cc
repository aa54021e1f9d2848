#include "core/io/ply.h"

#include <glog/logging.h>

#include <cstdint>
#include <cstring>
#include <ostream>

#include "core/io/atomic_file.h"

namespace arborslam {
namespace {

// Appends the bytes of `value`, lowest first, on machines of either order.
void Append(float value, std::string* record) {
  static_assert(sizeof(float) == sizeof(uint32_t), "PLY's float has 32 bits");
  uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  for (int shift = 0; shift < 32; shift += 8) record->push_back(static_cast<char>((bits >> shift) & 0xFF));
}

}  // namespace

void WritePly(const std::string& path, const std::vector<Eigen::Vector3f>& points, const std::vector<Colour>& colours) {
  CHECK(colours.empty() || colours.size() == points.size())
      << colours.size() << " colours, " << points.size() << " points";
  AtomicFile file(path);
  std::ostream& stream = file.stream();
  stream << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
         << "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!colours.empty()) stream << "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  stream << "end_header\n";
  std::string record;
  for (size_t i = 0; i < points.size(); ++i) {
    CHECK(points[i].allFinite()) << "point " << i;
    record.clear();
    for (const float coordinate : points[i]) Append(coordinate, &record);
    if (!colours.empty()) record.append(colours[i].begin(), colours[i].end());
    stream.write(record.data(), static_cast<std::streamsize>(record.size()));
  }
  file.Commit();
}

}  // namespace arborslam
