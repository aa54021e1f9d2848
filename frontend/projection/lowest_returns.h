#ifndef ARBORSLAM_FRONTEND_PROJECTION_LOWEST_RETURNS_H_
#define ARBORSLAM_FRONTEND_PROJECTION_LOWEST_RETURNS_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace arborslam {

/// The lowest return in each cell of a grid around the lidar: where ground is in sight, these lie on it or a little
/// below the grass on it. Ground fit and ground model start from them.
class LowestReturns {
 public:
  /// @param cell_size [m].
  /// @param min_range [m], nearer returns are the robot itself.
  /// @param max_range [m], half the edge of the grid.
  LowestReturns(float cell_size, float min_range, float max_range);

  /// Finds the lowest returns of `points` [m, lidar frame] along `up` (unit vector, lidar frame), in the order of the
  /// cells.
  const std::vector<Eigen::Vector3f>& Find(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& up);

  /// What `Find` found last.
  const std::vector<Eigen::Vector3f>& returns() const { return returns_; }

 private:
  struct Cell {
    float height;
    uint32_t point;
  };

  float inverse_cell_size_;
  float min_range_squared_;
  float max_range_;
  int width_;  // [cells]
  std::vector<Cell> cells_;
  std::vector<Eigen::Vector3f> returns_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_FRONTEND_PROJECTION_LOWEST_RETURNS_H_
