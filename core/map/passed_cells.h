#ifndef ARBORSLAM_CORE_MAP_PASSED_CELLS_H_
#define ARBORSLAM_CORE_MAP_PASSED_CELLS_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace arborslam {

/// Which cells of a plane the rays of one scan pass: one bit each, in a box of square tiles of 64 by 64 cells. Tile
/// (0, 0) begins at the plane's origin; cell (x, y) covers [x, x + 1) by [y, y + 1).
class PassedCells {
 public:
  static constexpr int kTileBits = 6;
  static constexpr int kTileCells = 1 << kTileBits;  ///< [cells], edge of a tile: a row of it is one word.

  /// No cell passed, in the box of the tiles that hold the points from `low` to `high` [cells].
  PassedCells(const Eigen::Vector2d& low, const Eigen::Vector2d& high);

  /// Marks the cells that the ray from `from` to `to` [cells], both in the box, runs through, all but the last. Cells
  /// met at a corner only may be among them. Seen only after `Finish`.
  void CastRay(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  /// Ends the casting.
  void Finish();

  /// Takes back that a cell was passed; any cell of the plane.
  void Remove(int64_t x, int64_t y) {
    if (Contains(x, y)) rows_[Word(x, y)] &= ~Bit(x);
  }
  /// True if the cell, any of the plane, was passed.
  bool Has(int64_t x, int64_t y) const { return Contains(x, y) && (rows_[Word(x, y)] & Bit(x)) != 0; }

  int64_t first_tile_x() const { return first_x_ >> kTileBits; }  ///< The box's first column of tiles.
  int64_t first_tile_y() const { return first_y_ >> kTileBits; }  ///< Its first row of tiles.
  int tiles_x() const { return tiles_x_; }                        ///< [tiles] along x.
  int tiles_y() const { return tiles_y_; }                        ///< [tiles] along y.
  /// Row `row` of the tile in the box's column `tile_x` and row `tile_y`: bit i tells of the row's i-th cell.
  uint64_t Row(int tile_x, int tile_y, int row) const {
    return rows_[(static_cast<size_t>(tile_y) * kTileCells + static_cast<size_t>(row)) * static_cast<size_t>(tiles_x_) +
                 static_cast<size_t>(tile_x)];
  }

 private:
  bool Contains(int64_t x, int64_t y) const {
    return x >= first_x_ && y >= first_y_ && (x - first_x_) >> kTileBits < tiles_x_ &&
           (y - first_y_) >> kTileBits < tiles_y_;
  }
  size_t Word(int64_t x, int64_t y) const {
    return static_cast<size_t>(y - first_y_) * static_cast<size_t>(tiles_x_) +
           static_cast<size_t>((x - first_x_) >> kTileBits);
  }
  static uint64_t Bit(int64_t x) { return uint64_t{1} << (x & (kTileCells - 1)); }

  int64_t first_x_;  // The box's first column of cells.
  int64_t first_y_;
  int tiles_x_;
  int tiles_y_;
  std::vector<uint64_t> rows_;  // Word by word, row by row. Of rays that are flatter than steep, while these are cast.
  std::vector<uint64_t> columns_;  // The same with x and y exchanged, of steep rays: empty when there are none.
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_PASSED_CELLS_H_
