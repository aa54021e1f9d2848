#ifndef ARBORSLAM_CORE_MAP_TERRAIN_MAP_H_
#define ARBORSLAM_CORE_MAP_TERRAIN_MAP_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>

namespace arborslam {

/// The ground's height over a plane, from samples of it: a grid whose cells keep the mean of their samples.
class TerrainMap {
 public:
  /// @param cell_size [m], above 0.
  explicit TerrainMap(double cell_size) : cell_size_(cell_size) {}

  /// Adds `weight` (above 0) of ground at `point` [m].
  void Insert(const Eigen::Vector3d& point, double weight);

  /// The ground as a plane around a place.
  struct Surface {
    double z = 0.0;                                   ///< [m]
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< dz/dx, dz/dy.
  };

  /// The weighted least-squares plane through the cell at `position` [m] and its neighbours, drawn towards the level
  /// where these are few; nothing where neither the cell nor a neighbour beside it was seen.
  std::optional<Surface> At(const Eigen::Vector2d& position) const;

  size_t num_cells() const { return cells_.size(); }

 private:
  struct Cell {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weight = 0.0;
  };

  int64_t Index(double coordinate) const;
  static uint64_t Key(int64_t x, int64_t y);

  double cell_size_;
  std::unordered_map<uint64_t, Cell> cells_;  // Never walked over, so that its order does not matter.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_TERRAIN_MAP_H_
