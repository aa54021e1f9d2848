#include "core/map/occupancy_grid.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace arborslam {
namespace {

int64_t FloorToInt(double value) { return static_cast<int64_t>(std::floor(value)); }

}  // namespace

double LogOddsOf(double probability) { return std::log(probability / (1.0 - probability)); }
double ProbabilityOf(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

std::string OccupancyGridOptions::Validate() const {
  std::ostringstream error;
  if (!(cell_size >= 0.001 && cell_size <= 1.0)) {
    error << "cell_size is " << cell_size << " m, must lie in [0.001, 1]";
  } else if (!(hit_probability > 0.5 && hit_probability < 1.0)) {
    error << "hit_probability is " << hit_probability << ", must lie in (0.5, 1)";
  } else if (!(miss_probability > 0.0 && miss_probability < 0.5)) {
    error << "miss_probability is " << miss_probability << ", must lie in (0, 0.5)";
  } else if (!(miss_range >= 0.0)) {
    error << "miss_range is " << miss_range << " m, must be at least 0";
  } else if (!(min_probability > 0.0 && min_probability < 0.5)) {
    error << "min_probability is " << min_probability << ", must lie in (0, 0.5)";
  } else if (!(max_probability > 0.5 && max_probability < 1.0)) {
    error << "max_probability is " << max_probability << ", must lie in (0.5, 1)";
  }
  return error.str();
}

OccupancyGrid::OccupancyGrid(const OccupancyGridOptions& options)
    : options_(options),
      hit_log_odds_(static_cast<float>(LogOddsOf(options.hit_probability))),
      miss_log_odds_(static_cast<float>(LogOddsOf(options.miss_probability))),
      min_log_odds_(static_cast<float>(LogOddsOf(options.min_probability))),
      max_log_odds_(static_cast<float>(LogOddsOf(options.max_probability))) {}

Eigen::Vector2d OccupancyGrid::origin() const {
  return Eigen::Vector2d(static_cast<double>(first_x_), static_cast<double>(first_y_)) * options_.cell_size;
}

PassedCells OccupancyGrid::Insert(const SE2& T_grid_base, const PlanarScan& scan) {
  const double inverse_cell = 1.0 / options_.cell_size;
  Eigen::Vector2d low = T_grid_base.translation();
  Eigen::Vector2d high = low;
  std::vector<Eigen::Vector2d> hits;
  std::vector<Eigen::Vector2d> free_ends;
  hits.reserve(scan.points.size());
  free_ends.reserve(scan.free_ends.size());
  for (const Eigen::Vector2f& point : scan.points) hits.push_back(T_grid_base * point.cast<double>());
  for (const Eigen::Vector2f& end : scan.free_ends) free_ends.push_back(T_grid_base * end.cast<double>());
  for (const auto* ends : {&hits, &free_ends}) {
    for (const Eigen::Vector2d& end : *ends) {
      low = low.cwiseMin(end);
      high = high.cwiseMax(end);
    }
  }
  Cover(low, high);
  ++scan_;

  // All in cells of the plane.
  const Eigen::Vector2d from = T_grid_base.translation() * inverse_cell;
  const double miss_range = options_.miss_range * inverse_cell;
  std::vector<Eigen::Vector2d> ray_ends;
  ray_ends.reserve(hits.size() + free_ends.size());
  low = high = from;
  for (const auto* ends : {&hits, &free_ends}) {
    if (ends == &hits && !scan.point_rays_are_free) continue;
    for (const Eigen::Vector2d& end : *ends) {
      const Eigen::Vector2d ray = end * inverse_cell - from;
      ray_ends.push_back(from + std::min(1.0, miss_range / ray.norm()) * ray);
      low = low.cwiseMin(ray_ends.back());
      high = high.cwiseMax(ray_ends.back());
    }
  }
  PassedCells passed(low, high);
  for (const Eigen::Vector2d& end : ray_ends) passed.CastRay(from, end);
  passed.Finish();

  for (const Eigen::Vector2d& hit : hits) {
    const Eigen::Vector2d position = hit * inverse_cell;
    const int64_t plane_x = FloorToInt(position.x());
    const int64_t plane_y = FloorToInt(position.y());
    const auto x = static_cast<int>(plane_x - first_x_);
    const auto y = static_cast<int>(plane_y - first_y_);
    Tile* tile = MakeTile(x, y);
    uint32_t& entry = tile->hits[IndexInTile(x, y)];
    if (entry == 0) {
      hits_.push_back({plane_x, plane_y, Eigen::Vector2f::Zero(), 0.0f, 0});
      entry = static_cast<uint32_t>(hits_.size());
    }
    Hits& sum = hits_[entry - 1];
    const Eigen::Vector2d corner(static_cast<double>(plane_x), static_cast<double>(plane_y));
    sum.sum += (options_.cell_size * (position - corner)).cast<float>();
    sum.count += 1.0f;
    if (sum.last_scan == scan_) continue;
    sum.last_scan = scan_;
    float& log_odds = tile->log_odds[IndexInTile(x, y)];
    log_odds = std::min(log_odds + hit_log_odds_, max_log_odds_);
    tile->known[RowInTile(y)] |= uint64_t{1} << (x & (kTileCells - 1));
    passed.Remove(plane_x, plane_y);
  }
  Miss(passed);
  return passed;
}

void OccupancyGrid::Miss(const PassedCells& passed) {
  // What each of four neighbouring cells gains, by whether they were passed. Nothing is below the minimum, so that the
  // others stay what they are.
  std::array<Eigen::Array4f, 16> gains;
  for (size_t bits = 0; bits < gains.size(); ++bits) {
    for (int i = 0; i < 4; ++i) gains[bits](i) = (bits >> i & 1) != 0 ? miss_log_odds_ : 0.0f;
  }
  const int first_tile_x = static_cast<int>(passed.first_tile_x() - (first_x_ >> kTileBits));
  const int first_tile_y = static_cast<int>(passed.first_tile_y() - (first_y_ >> kTileBits));
  for (int tile_y = 0; tile_y < passed.tiles_y(); ++tile_y) {
    for (int tile_x = 0; tile_x < passed.tiles_x(); ++tile_x) {
      Tile* tile = nullptr;
      for (int row = 0; row < kTileCells; ++row) {
        uint64_t bits = passed.Row(tile_x, tile_y, row);
        if (bits == 0) continue;
        if (tile == nullptr) {
          tile = MakeTile((first_tile_x + tile_x) * kTileCells, (first_tile_y + tile_y) * kTileCells);
        }
        tile->known[static_cast<size_t>(row)] |= bits;
        float* cells = &tile->log_odds[IndexInTile(0, row)];
        for (; bits != 0; bits >>= 4, cells += 4) {
          Eigen::Map<Eigen::Array4f, Eigen::Aligned16> four(cells);
          four = (four + gains[bits & 15]).max(min_log_odds_);
        }
      }
    }
  }
}

OccupancyGrid::Tile* OccupancyGrid::MakeTile(int x, int y) {
  std::unique_ptr<Tile>& tile = tiles_[TileIndex(x, y)];
  if (!tile) tile = std::make_unique<Tile>();
  return tile.get();
}

void OccupancyGrid::Cover(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  // One cell of margin on every side, in whole tiles of the plane.
  const auto tile_of = [this](double position, int margin) {
    return (FloorToInt(position / options_.cell_size) + margin) >> kTileBits;
  };
  int64_t low_x = tile_of(low.x(), -1);
  int64_t low_y = tile_of(low.y(), -1);
  int64_t end_x = tile_of(high.x(), 1) + 1;
  int64_t end_y = tile_of(high.y(), 1) + 1;
  const int64_t old_x = first_x_ >> kTileBits;
  const int64_t old_y = first_y_ >> kTileBits;
  if (!tiles_.empty()) {
    if (low_x >= old_x && low_y >= old_y && end_x <= old_x + tiles_x_ && end_y <= old_y + tiles_y_) return;
    low_x = std::min(low_x, old_x);
    low_y = std::min(low_y, old_y);
    end_x = std::max(end_x, old_x + tiles_x_);
    end_y = std::max(end_y, old_y + tiles_y_);
  }
  const auto new_tiles_x = static_cast<size_t>(end_x - low_x);
  std::vector<std::unique_ptr<Tile>> grown(new_tiles_x * static_cast<size_t>(end_y - low_y));
  for (int y = 0; y < tiles_y_; ++y) {
    const auto from = tiles_.begin() + static_cast<ptrdiff_t>(y) * tiles_x_;
    const size_t to = static_cast<size_t>(y + old_y - low_y) * new_tiles_x + static_cast<size_t>(old_x - low_x);
    std::move(from, from + tiles_x_, grown.begin() + static_cast<ptrdiff_t>(to));
  }
  tiles_ = std::move(grown);
  tiles_x_ = static_cast<int>(new_tiles_x);
  tiles_y_ = static_cast<int>(end_y - low_y);
  first_x_ = low_x * kTileCells;
  first_y_ = low_y * kTileCells;
}

std::vector<OccupiedCell> OccupancyGrid::OccupiedCells(float min_log_odds) const {
  std::vector<OccupiedCell> cells;
  for (const Hits& hits : hits_) {
    const float log_odds = LogOdds(static_cast<int>(hits.x - first_x_), static_cast<int>(hits.y - first_y_));
    if (log_odds < min_log_odds) continue;
    const Eigen::Vector2d corner =
        Eigen::Vector2d(static_cast<double>(hits.x), static_cast<double>(hits.y)) * options_.cell_size;
    cells.push_back({(corner + (hits.sum / hits.count).cast<double>()).cast<float>(), log_odds});
  }
  return cells;
}

}  // namespace arborslam
