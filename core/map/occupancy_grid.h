#ifndef ARBORSLAM_CORE_MAP_OCCUPANCY_GRID_H_
#define ARBORSLAM_CORE_MAP_OCCUPANCY_GRID_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/passed_cells.h"
#include "core/sensor/planar_scan.h"

namespace arborslam {

/// How a grid weighs its evidence.
struct OccupancyGridOptions {
  double cell_size = 0.05;        ///< [m], edge of a cell.
  double hit_probability = 0.7;   ///< P(occupied | the cell was hit), in (0.5, 1). The paper's public code has 0.8.
  double miss_probability = 0.4;  ///< P(occupied | a ray passed), in (0, 0.5). The paper's public code has 0.2.
  double miss_range = 8.0;        ///< [m], rays count as misses this far: farther out they lie more than a cell apart.
  double min_probability = 0.12;  ///< Log-odds are clamped here from below, so that a cell can be won back.
  double max_probability = 0.97;  ///< Log-odds are clamped here from above, so that a cell can be lost again.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("cell_size", cell_size);
    visit("hit_probability", hit_probability);
    visit("miss_probability", miss_probability);
    visit("miss_range", miss_range);
    visit("min_probability", min_probability);
    visit("max_probability", max_probability);
  }
};

/// A cell that holds something, with the mean of the hits it received.
struct OccupiedCell {
  Eigen::Vector2f centroid;  ///< [m], in the grid's frame: where in the cell the returns lie.
  float log_odds;            ///< of being occupied.

  template <class Visitor>
  void VisitState(Visitor&& visit) {
    visit(centroid, log_odds);
  }
};

/// Log-odds occupancy over a plane that grows as scans come in (Moravec and Elfes 1985; Thrun et al. 2005, ch. 9).
/// A scan updates a cell once: a hit if any of its returns lies in it, else a miss if any ray passes through it.
class OccupancyGrid {
 public:
  explicit OccupancyGrid(const OccupancyGridOptions& options);

  /// Adds a scan taken at `T_grid_base`. Returns the cells of the plane that it counts as missed.
  PassedCells Insert(const SE2& T_grid_base, const PlanarScan& scan);

  int width() const { return tiles_x_ * kTileCells; }   ///< [cells] along x.
  int height() const { return tiles_y_ * kTileCells; }  ///< [cells] along y.
  double cell_size() const { return options_.cell_size; }
  /// Corner [m] of cell (0, 0) in the grid's frame.
  Eigen::Vector2d origin() const;

  /// Log-odds of the cell at column `x`, row `y`; 0 where nothing is known.
  float LogOdds(int x, int y) const {
    const Tile* tile = TileOf(x, y);
    return tile == nullptr ? 0.0f : tile->log_odds[IndexInTile(x, y)];
  }
  /// True if a ray ever met or passed the cell.
  bool IsKnown(int x, int y) const {
    const Tile* tile = TileOf(x, y);
    return tile != nullptr && (tile->known[RowInTile(y)] >> (x & (kTileCells - 1)) & 1) != 0;
  }

  /// Cells that were hit and whose log-odds are at least `min_log_odds`, in the order of their first hits.
  std::vector<OccupiedCell> OccupiedCells(float min_log_odds) const;

 private:
  // What is kept of a cell that was hit.
  struct Hits {
    int64_t x;  // The cell of the plane.
    int64_t y;
    Eigen::Vector2f sum;  // Of the hits' positions relative to the cell's corner [m].
    float count;
    uint32_t last_scan;  // Number of the last scan that hit the cell, from 1 on.
  };

  // Cells are kept in square tiles, made when a ray first enters them, so that growing moves none and land that nobody
  // has seen costs nothing.
  static constexpr int kTileBits = PassedCells::kTileBits;
  static constexpr int kTileCells = PassedCells::kTileCells;
  static constexpr size_t kTileArea = static_cast<size_t>(kTileCells) * kTileCells;
  struct Tile {
    alignas(16) std::array<float, kTileArea> log_odds;  // Row by row.
    std::array<uint32_t, kTileArea> hits;               // Index into hits_ plus 1, or 0.
    std::array<uint64_t, kTileCells> known;             // A word per row: if a ray ever met or passed the cells.
  };

  static size_t IndexInTile(int x, int y) {
    return static_cast<size_t>(((y & (kTileCells - 1)) << kTileBits) | (x & (kTileCells - 1)));
  }
  static size_t RowInTile(int y) { return static_cast<size_t>(y & (kTileCells - 1)); }
  size_t TileIndex(int x, int y) const {
    return static_cast<size_t>(y >> kTileBits) * static_cast<size_t>(tiles_x_) + static_cast<size_t>(x >> kTileBits);
  }
  const Tile* TileOf(int x, int y) const { return tiles_[TileIndex(x, y)].get(); }
  Tile* MakeTile(int x, int y);
  // Grows the grid so that it covers the box [m].
  void Cover(const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  // A miss for each of these cells, which `Cover` covers.
  void Miss(const PassedCells& passed);

  OccupancyGridOptions options_;
  float hit_log_odds_;
  float miss_log_odds_;
  float min_log_odds_;
  float max_log_odds_;
  int64_t first_x_ = 0;  // Cell (0, 0) covers [first_x_, first_x_ + 1) * cell_size; a multiple of kTileCells.
  int64_t first_y_ = 0;
  int tiles_x_ = 0;
  int tiles_y_ = 0;
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::vector<Hits> hits_;
  uint32_t scan_ = 0;
};

/// log(p / (1 - p)).
double LogOddsOf(double probability);
/// The inverse of `LogOddsOf`.
double ProbabilityOf(double log_odds);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_OCCUPANCY_GRID_H_
