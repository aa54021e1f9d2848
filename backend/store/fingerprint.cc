#include "backend/store/fingerprint.h"

#include <cstddef>
#include <cstring>
#include <variant>

namespace arborslam {
namespace {

// Eight bytes at a time: multiply and fold, as in the hash functions of Yann Collet's xxHash family.
class Hash {
 public:
  void Add(const void* data, size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (; size >= sizeof(uint64_t); size -= sizeof(uint64_t), bytes += sizeof(uint64_t)) {
      uint64_t word = 0;
      std::memcpy(&word, bytes, sizeof(word));
      Mix(word);
    }
    uint64_t rest = size;
    if (size > 0) std::memcpy(&rest, bytes, size);
    Mix(rest);
  }
  uint64_t Get() const { return state_ == 0 ? 1 : state_; }

 private:
  void Mix(uint64_t word) {
    state_ = (state_ ^ word) * 0x9E3779B185EBCA87u;
    state_ ^= state_ >> 29;
  }

  uint64_t state_ = 0xC2B2AE3D27D4EB4Fu;
};

}  // namespace

uint64_t FingerprintOf(const Scan& scan) {
  Hash hash;
  if (const auto* planar = std::get_if<LaserScan>(&scan)) {
    hash.Add(&planar->stamp, sizeof(double));
    hash.Add(planar->ranges.data(), planar->ranges.size() * sizeof(float));
    if (planar->odometry) {
      const Eigen::Vector3d odometry = planar->odometry->vector();
      hash.Add(odometry.data(), 3 * sizeof(double));
    }
  } else {
    const auto& sweep = std::get<LidarSweep>(scan);
    hash.Add(&sweep.start, sizeof(double));
    hash.Add(sweep.points.data(), sweep.points.size() * sizeof(Eigen::Vector3f));
  }
  return hash.Get();
}

}  // namespace arborslam
