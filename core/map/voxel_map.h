#ifndef ARBORSLAM_CORE_MAP_VOXEL_MAP_H_
#define ARBORSLAM_CORE_MAP_VOXEL_MAP_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace arborslam {

/// The 3D map: space in cubes ("voxels"), each with the mean of the points that fell into it. Memory grows with the
/// number of voxels, about 50 bytes each, not with that of the points. The same calls give the same bits on every
/// machine. Not thread-safe.
class VoxelMap {
 public:
  /// @param voxel_size edge of a voxel [m], above 0.
  /// @param max_voxels when the map holds more after a sweep, it merges its voxels by eight into ones of twice the
  /// edge;
  ///                   at least 9, because the eight around the origin never merge, and below 2^31.
  VoxelMap(double voxel_size, size_t max_voxels);

  /// Adds the points of one sweep, in the map's frame [m]. Points that are not finite, or lie a million voxels or more
  /// from the origin along an axis, are refused and counted.
  void AddSweep(const std::vector<Eigen::Vector3f>& points);

  /// Means [m] of the voxels that at least `min_sweeps` sweeps met, in the order in which the voxels were first met.
  /// A person who walks by meets a place in few sweeps, however many points a sweep has there.
  std::vector<Eigen::Vector3f> Points(int min_sweeps) const;

  size_t size() const { return voxels_.size(); }
  /// [m], in effect now: the one asked for times a power of two.
  double voxel_size() const { return voxel_size_; }
  size_t num_refused() const { return num_refused_; }

 private:
  struct Voxel {
    uint64_t key;          // Its place in the lattice, 21 bits an axis.
    Eigen::Vector3f mean;  // Of its points, from its corner, in edges.
    uint32_t num_points;
    uint32_t num_sweeps;  // After a merge a lower bound: the most of the eight.
    uint32_t last_sweep;  // Number of the last sweep that met it, from 1 on.
  };

  void AddPoint(const Eigen::Vector3f& point, uint64_t key);
  // The entry of the table where the search for this key begins.
  size_t HomeSlot(uint64_t key) const;
  // The one where it ends: that of the key's voxel, or the empty one where it belongs.
  size_t SlotOf(uint64_t key) const;
  Voxel& FindOrAdd(uint64_t key);
  // Doubles the table.
  void GrowTable();
  // Merges voxels by eight, doubling their edge.
  void Coarsen();

  double voxel_size_;
  size_t max_voxels_;
  std::deque<Voxel> voxels_;     // In the order of their first points; a deque, because a vector copies itself to grow.
  std::vector<uint32_t> table_;  // Index into voxels_ plus 1, or 0; open addressing, at most half full, 2^n entries.
  std::vector<uint64_t> keys_;   // Of the sweep that is being added.
  uint32_t sweep_ = 0;
  size_t num_refused_ = 0;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_VOXEL_MAP_H_
