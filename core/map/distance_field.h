#ifndef ARBORSLAM_CORE_MAP_DISTANCE_FIELD_H_
#define ARBORSLAM_CORE_MAP_DISTANCE_FIELD_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace arborslam {

/// How a distance between two cells is measured.
enum class DistanceMetric {
  kL1,  ///< |dx| + |dy|, the paper's D(p, M).
  kL2,  ///< Euclidean.
};

/// For every cell of a plane the exact distance to, and the identity of, the nearest of a set of cells, as far as
/// `max_distance`. Built in two separable passes in time linear in the cells within `max_distance` of the set
/// (Felzenszwalb and Huttenlocher 2012 for L2; Meijster et al. 2000), so that empty land costs nothing but its memory.
class DistanceField {
 public:
  /// A field without any occupied cell: `max_distance` everywhere.
  DistanceField() = default;

  /// @param points        [m], one in each occupied cell; the cell of a point is floor(point / cell_size). Where two
  /// lie
  ///                      in one cell the first counts.
  /// @param cell_size     [m], > 0.
  /// @param max_distance  [m], >= 0, at most 150 cells; cells farther from the set than this hold `max_distance`.
  DistanceField(const std::vector<Eigen::Vector2f>& points, double cell_size, double max_distance,
                DistanceMetric metric);

  /// Index into `points` of the occupied cell nearest to the cell that `point` [m] lies in, or -1 when it is farther
  /// than the truncation.
  int Nearest(const Eigen::Vector2f& point) const {
    const int x = static_cast<int>(std::floor(point.x() * inverse_cell_size_)) - first_x_;
    const int y = static_cast<int>(std::floor(point.y() * inverse_cell_size_)) - first_y_;
    return Contains(x, y) ? NearestAt(x, y) : -1;
  }
  /// Distance [m] between the cell that `point` [m] lies in and the nearest occupied cell, centre to centre.
  float Distance(const Eigen::Vector2f& point) const {
    const int x = static_cast<int>(std::floor(point.x() * inverse_cell_size_)) - first_x_;
    const int y = static_cast<int>(std::floor(point.y() * inverse_cell_size_)) - first_y_;
    return Contains(x, y) ? DistanceAt(x, y) : max_distance_;
  }

  /// The same by cell of the field's own array; (0, 0) is the cell `first_x()`, `first_y()` of the plane.
  int NearestAt(int x, int y) const {
    const size_t index = Index(x, y);
    return steps_[index] == too_far_ ? -1 : nearest_[index];
  }
  float DistanceAt(int x, int y) const { return metres_[steps_[Index(x, y)]]; }

  /// Every cell's distance rounded down to `num_steps` (at most 255) equal steps of the truncation, columns contiguous.
  std::vector<uint8_t> Quantised(int num_steps) const;

  int width() const { return width_; }      ///< [cells] along x; the occupied cells and a margin of the truncation.
  int height() const { return height_; }    ///< [cells] along y.
  int first_x() const { return first_x_; }  ///< Cell (x, y) covers [(first_x + x) * cell_size, ... + cell_size).
  int first_y() const { return first_y_; }
  float cell_size() const { return cell_size_; }        ///< [m]
  float max_distance() const { return max_distance_; }  ///< [m]

 private:
  bool Contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  // Columns are contiguous: the second pass writes along them.
  size_t Index(int x, int y) const {
    return static_cast<size_t>(x) * static_cast<size_t>(height_) + static_cast<size_t>(y);
  }

  float cell_size_ = 1.0f;
  float inverse_cell_size_ = 1.0f;
  float max_distance_ = 0.0f;
  int first_x_ = 0;
  int first_y_ = 0;
  int width_ = 0;
  int height_ = 0;
  uint16_t too_far_ = 0;                // The step count of cells beyond the truncation.
  std::unique_ptr<int32_t[]> nearest_;  // Not set where steps_ is too_far_: most land is, and need not be touched.
  std::vector<uint16_t> steps_;         // Cells (L1) or cells squared (L2) to the nearest.
  std::vector<float> metres_;           // What a step count is in metres.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_DISTANCE_FIELD_H_
