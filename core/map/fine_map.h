#ifndef ARBORSLAM_CORE_MAP_FINE_MAP_H_
#define ARBORSLAM_CORE_MAP_FINE_MAP_H_

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/io/map_io.h"

namespace arborslam {

/// The map as it is written.
struct FineMapOptions {
  /// [m], edge of the map's cells; 0: grid.cell_size. Sweeps in space make a `FineMap` of cells smaller than that.
  double resolution = 0.0;
  /// [m], across: what stands alone and is no larger is taken to be round where nobody could look; 0: nothing is.
  double max_round_size = 0.6;

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("resolution", resolution);
    visit("max_round_size", max_round_size);
  }
};

/// The footprints of things in cells so small that a sweep meets each of them seldom, so that odds of single cells
/// would not do. Persistent evidence in larger cells says where something stands; there, and a little around it, the
/// returns are counted that come from solid things and those that come from the ground, both smoothed over the range
/// noise, and a cell is occupied when the solid ones are more. Counting both, it does not matter how often a place was
/// seen, and edges lie where they belong although the noise blurs them. What is small and stands alone becomes round:
/// the smallest circle around it without the cells where the ground was seen, so that a trunk or a cone that was passed
/// on one side only has a back.
class FineMap {
 public:
  /// @param evidence cells above 65 % are where something stands.
  /// @param options  valid, with a resolution above 0. Throws `UserError` if the map would be too large.
  FineMap(const GridImage& evidence, const FineMapOptions& options);

  /// Counts a return [m, the map's frame] of something solid or of the ground.
  void AddSolid(const Eigen::Vector2d& position) { Count(position, &Tile::solid); }
  void AddGround(const Eigen::Vector2d& position) { Count(position, &Tile::ground); }

  /// The map of `evidence` in small cells: those of the footprints are 100, others are as probable as the evidence has
  /// them, or 0 where it is refuted. Evidence stands where nothing was counted.
  GridImage Image() const;

 private:
  static constexpr int kTileBits = 6;
  static constexpr int kTileCells = 1 << kTileBits;
  static constexpr size_t kTileArea = static_cast<size_t>(kTileCells) * kTileCells;
  using Counts = std::array<uint16_t, kTileArea>;
  // There are tiles near evidence only.
  struct Tile {
    Counts solid{};
    Counts ground{};
    std::bitset<kTileArea> is_near;  // To evidence: cells that count at all.
  };
  struct Cell {
    int x;
    int y;
  };
  // What was counted in a cell and, the less the farther, around it.
  struct Density {
    float solid = 0.0f;
    float ground = 0.0f;
    float peak = 0.0f;  // Of `solid`, of all cells around.
  };
  using Densities = std::vector<std::unique_ptr<std::array<Density, kTileArea>>>;  // One a tile.

  bool IsInside(int x, int y) const { return x >= 0 && x < width_ && y >= 0 && y < height_; }
  size_t TileIndex(int x, int y) const {
    return static_cast<size_t>(y >> kTileBits) * static_cast<size_t>(tiles_x_) + static_cast<size_t>(x >> kTileBits);
  }
  static size_t IndexInTile(int x, int y) {
    return static_cast<size_t>(((y & (kTileCells - 1)) << kTileBits) | (x & (kTileCells - 1)));
  }
  size_t IndexInImage(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }
  uint8_t EvidenceAt(int x, int y) const;
  void MarkNear();
  void Count(const Eigen::Vector2d& position, Counts Tile::*counts);
  Densities Smooth() const;
  Density DensityAt(const Densities& densities, int x, int y) const;
  // Occupied cells that hang together, give or take a narrow gap; `seen` has a mark for every cell of the image.
  std::vector<Cell> Component(const Cell& first, const GridImage& image, std::vector<bool>* seen) const;
  void RoundOff(const std::vector<Cell>& component, const Densities& densities, GridImage* image) const;

  GridImage evidence_;
  FineMapOptions options_;
  int width_;   // [cells]
  int height_;  // [cells]
  int tiles_x_;
  int tiles_y_;
  std::vector<std::unique_ptr<Tile>> tiles_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_MAP_FINE_MAP_H_
