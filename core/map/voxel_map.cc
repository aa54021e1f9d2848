#include "core/map/voxel_map.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

constexpr size_t kFirstTableSize = 1 << 12;
// 21 bits an axis make a key of 63.
constexpr int kAxisBits = 21;
constexpr int64_t kAxisMask = (int64_t{1} << kAxisBits) - 1;
constexpr int64_t kAxisOffset = int64_t{1} << (kAxisBits - 1);
constexpr double kMaxIndex = 1e6;  // What `AddSweep` promises.
static_assert(kMaxIndex < static_cast<double>(kAxisOffset), "every index must fit its bits");

// No voxel's key, which has 63 bits.
constexpr uint64_t kNoKey = ~uint64_t{0};
// [points], enough for a place to arrive from memory.
constexpr size_t kLookahead = 16;

struct Cell {
  int64_t x, y, z;
};

// Of a position in edges.
Cell CellOf(const Eigen::Vector3d& position) {
  return {static_cast<int64_t>(std::floor(position.x())), static_cast<int64_t>(std::floor(position.y())),
          static_cast<int64_t>(std::floor(position.z()))};
}

uint64_t KeyOf(const Cell& cell) {
  return static_cast<uint64_t>(((cell.x + kAxisOffset) << (2 * kAxisBits)) | ((cell.y + kAxisOffset) << kAxisBits) |
                               (cell.z + kAxisOffset));
}

Cell CellOf(uint64_t key) {
  const auto bits = static_cast<int64_t>(key);
  return {((bits >> (2 * kAxisBits)) & kAxisMask) - kAxisOffset, ((bits >> kAxisBits) & kAxisMask) - kAxisOffset,
          (bits & kAxisMask) - kAxisOffset};
}

// In edges.
Eigen::Vector3d CornerOf(uint64_t key) {
  const Cell cell = CellOf(key);
  return {static_cast<double>(cell.x), static_cast<double>(cell.y), static_cast<double>(cell.z)};
}

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): neighbouring voxels differ in few bits.
uint64_t Hash(uint64_t key) {
  key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9ull;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBull;
  return key ^ (key >> 31);
}

}  // namespace

VoxelMap::VoxelMap(double voxel_size, size_t max_voxels)
    : voxel_size_(voxel_size), max_voxels_(max_voxels), table_(kFirstTableSize, 0) {
  CHECK(std::isfinite(voxel_size) && voxel_size > 0.0) << voxel_size;
  CHECK_GE(max_voxels, 9u);
  CHECK_LT(max_voxels, size_t{1} << 31);
}

void VoxelMap::AddSweep(const std::vector<Eigen::Vector3f>& points) {
  ++sweep_;
  keys_.clear();
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d position = point.cast<double>() / voxel_size_;
    const bool is_refused = !position.allFinite() || position.cwiseAbs().maxCoeff() >= kMaxIndex;
    keys_.push_back(is_refused ? kNoKey : KeyOf(CellOf(position)));
  }
  // A place is seldom in the processor's cache: it is asked for ahead of its turn, first its slot, then its voxel.
  for (size_t i = 0; i < points.size(); ++i) {
    if (i + 2 * kLookahead < points.size()) __builtin_prefetch(&table_[HomeSlot(keys_[i + 2 * kLookahead])]);
    if (i + kLookahead < points.size()) {
      const uint32_t entry = table_[HomeSlot(keys_[i + kLookahead])];
      if (entry != 0) __builtin_prefetch(&voxels_[entry - 1]);
    }
    if (keys_[i] == kNoKey) {
      ++num_refused_;
    } else {
      AddPoint(points[i], keys_[i]);
    }
  }
  // What lies far apart takes more than one step.
  while (voxels_.size() > max_voxels_) Coarsen();
}

void VoxelMap::AddPoint(const Eigen::Vector3f& point, uint64_t key) {
  Voxel& voxel = FindOrAdd(key);
  const Eigen::Vector3d offset = point.cast<double>() / voxel_size_ - CornerOf(key);
  // A running mean, because a sum of floats would lose its last digits.
  ++voxel.num_points;
  voxel.mean += (offset.cast<float>() - voxel.mean) / static_cast<float>(voxel.num_points);
  if (voxel.last_sweep != sweep_) ++voxel.num_sweeps;
  voxel.last_sweep = sweep_;
}

std::vector<Eigen::Vector3f> VoxelMap::Points(int min_sweeps) const {
  const auto is_kept = [min_sweeps](const Voxel& voxel) { return int64_t{voxel.num_sweeps} >= min_sweeps; };
  std::vector<Eigen::Vector3f> points;
  points.reserve(static_cast<size_t>(std::count_if(voxels_.begin(), voxels_.end(), is_kept)));
  for (const Voxel& voxel : voxels_) {
    if (!is_kept(voxel)) continue;
    points.push_back((voxel_size_ * (CornerOf(voxel.key) + voxel.mean.cast<double>())).cast<float>());
  }
  return points;
}

size_t VoxelMap::HomeSlot(uint64_t key) const { return static_cast<size_t>(Hash(key)) & (table_.size() - 1); }

size_t VoxelMap::SlotOf(uint64_t key) const {
  size_t slot = HomeSlot(key);
  while (table_[slot] != 0 && voxels_[table_[slot] - 1].key != key) slot = (slot + 1) & (table_.size() - 1);
  return slot;
}

VoxelMap::Voxel& VoxelMap::FindOrAdd(uint64_t key) {
  size_t slot = SlotOf(key);
  if (table_[slot] == 0) {
    if (2 * (voxels_.size() + 1) > table_.size()) {
      GrowTable();
      slot = SlotOf(key);
    }
    voxels_.push_back({key, Eigen::Vector3f::Zero(), 0, 0, 0});
    table_[slot] = static_cast<uint32_t>(voxels_.size());
  }
  return voxels_[table_[slot] - 1];
}

void VoxelMap::GrowTable() {
  table_.assign(2 * table_.size(), 0);
  for (size_t i = 0; i < voxels_.size(); ++i) table_[SlotOf(voxels_[i].key)] = static_cast<uint32_t>(i + 1);
}

void VoxelMap::Coarsen() {
  voxel_size_ *= 2.0;
  std::fill(table_.begin(), table_.end(), 0);
  std::deque<Voxel> fine;
  fine.swap(voxels_);
  for (; !fine.empty(); fine.pop_front()) {
    const Voxel& voxel = fine.front();
    const Cell cell = CellOf(voxel.key);
    // Shifts round towards minus infinity, as `floor` does.
    Voxel& merged = FindOrAdd(KeyOf({cell.x >> 1, cell.y >> 1, cell.z >> 1}));
    const Eigen::Vector3f octant(static_cast<float>(cell.x & 1), static_cast<float>(cell.y & 1),
                                 static_cast<float>(cell.z & 1));
    merged.num_points += voxel.num_points;
    merged.mean += (0.5f * (octant + voxel.mean) - merged.mean) *
                   (static_cast<float>(voxel.num_points) / static_cast<float>(merged.num_points));
    merged.num_sweeps = std::max(merged.num_sweeps, voxel.num_sweeps);
    merged.last_sweep = std::max(merged.last_sweep, voxel.last_sweep);
  }
}

}  // namespace arborslam
