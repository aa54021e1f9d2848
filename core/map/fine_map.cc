#include "core/map/fine_map.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "core/config/validation.h"
#include "core/error.h"
#include "core/geometry/enclosing_circle.h"

namespace arborslam {
namespace {

constexpr uint8_t kOccupied = 65;  // [%], above this something stands there.
// [m], around evidence: a cone is wider at its foot than where the evidence of it lies, the mean of its returns.
constexpr double kReach = 0.15;
constexpr double kBlur = 0.015;  // [m], standard deviation: somewhat less than the range noise of a usual lidar.
// Of the highest density within this [m], sideways and ahead, that a cell must reach: what is thin and tall is hit so
// often that the noise around it outweighs the ground.
constexpr float kPeakShare = 0.06f;
constexpr double kPeakReach = 0.07;
constexpr float kFewHits = 0.3f;  // Of a density of 1, a return in every cell: less than this is noise.
constexpr double kGap = 0.02;     // [m], to each side, that parts of one thing may lie apart.
constexpr double kMaxCells = 5e8;

// Of a Gaussian bell, from its middle on, so that the whole sums up to 1.
std::vector<float> HalfBell(double sigma) {
  std::vector<double> bell{1.0};
  double sum = 1.0;
  for (int i = 1; i <= static_cast<int>(std::ceil(3.0 * sigma)); ++i) {
    bell.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    sum += 2.0 * bell.back();
  }
  std::vector<float> half;
  for (const double value : bell) half.push_back(static_cast<float>(value / sum));
  return half;
}

}  // namespace

std::string FineMapOptions::Validate() const {
  if (!(resolution == 0.0 || (resolution >= 0.005 && resolution <= 1.0))) {
    return Violation("resolution", resolution, "be 0 or lie in [0.005, 1] m");
  }
  if (!(max_round_size >= 0.0 && max_round_size <= 5.0)) {
    return Violation("max_round_size", max_round_size, "lie in [0, 5] m");
  }
  return "";
}

FineMap::FineMap(const GridImage& evidence, const FineMapOptions& options) : evidence_(evidence), options_(options) {
  CHECK_GT(options.resolution, 0.0);
  const double ratio = evidence.resolution / options.resolution;
  const double width = std::ceil(evidence.width * ratio - 1e-6);
  const double height = std::ceil(evidence.height * ratio - 1e-6);
  if (!(width * height <= kMaxCells)) {
    throw UserError("map.resolution", "makes more than 5e8 cells of this map", "choose a larger one");
  }
  width_ = static_cast<int>(width);
  height_ = static_cast<int>(height);
  tiles_x_ = (width_ + kTileCells - 1) >> kTileBits;
  tiles_y_ = (height_ + kTileCells - 1) >> kTileBits;
  tiles_.resize(static_cast<size_t>(tiles_x_) * static_cast<size_t>(tiles_y_));
  MarkNear();
}

uint8_t FineMap::EvidenceAt(int x, int y) const {
  const double ratio = options_.resolution / evidence_.resolution;
  const int column = std::min(evidence_.width - 1, static_cast<int>((x + 0.5) * ratio));
  const int row = std::min(evidence_.height - 1, static_cast<int>((y + 0.5) * ratio));
  return evidence_
      .occupancy[static_cast<size_t>(row) * static_cast<size_t>(evidence_.width) + static_cast<size_t>(column)];
}

void FineMap::MarkNear() {
  const double ratio = evidence_.resolution / options_.resolution;
  const double reach = kReach / options_.resolution;
  for (int row = 0; row < evidence_.height; ++row) {
    for (int column = 0; column < evidence_.width; ++column) {
      const uint8_t value =
          evidence_
              .occupancy[static_cast<size_t>(row) * static_cast<size_t>(evidence_.width) + static_cast<size_t>(column)];
      if (value == GridImage::kUnknown || value <= kOccupied) continue;
      // All cells whose middle lies within reach of the evidence's cell.
      const double low_x = column * ratio;
      const double low_y = row * ratio;
      const int first_y = std::max(0, static_cast<int>(std::floor(low_y - reach)));
      const int last_y = std::min(height_ - 1, static_cast<int>(std::floor(low_y + ratio + reach)));
      const int first_x = std::max(0, static_cast<int>(std::floor(low_x - reach)));
      const int last_x = std::min(width_ - 1, static_cast<int>(std::floor(low_x + ratio + reach)));
      for (int y = first_y; y <= last_y; ++y) {
        for (int x = first_x; x <= last_x; ++x) {
          const double dx = x + 0.5 - std::clamp(x + 0.5, low_x, low_x + ratio);
          const double dy = y + 0.5 - std::clamp(y + 0.5, low_y, low_y + ratio);
          if (dx * dx + dy * dy > reach * reach) continue;
          std::unique_ptr<Tile>& tile = tiles_[TileIndex(x, y)];
          if (tile == nullptr) tile = std::make_unique<Tile>();
          tile->is_near.set(IndexInTile(x, y));
        }
      }
    }
  }
}

void FineMap::Count(const Eigen::Vector2d& position, Counts Tile::*counts) {
  const double column = std::floor((position.x() - evidence_.origin_x) / options_.resolution);
  const double row = std::floor((position.y() - evidence_.origin_y) / options_.resolution);
  if (!(column >= 0.0 && column < width_ && row >= 0.0 && row < height_)) return;
  const auto x = static_cast<int>(column);
  const auto y = static_cast<int>(row);
  Tile* tile = tiles_[TileIndex(x, y)].get();
  if (tile == nullptr) return;
  uint16_t& count = (tile->*counts)[IndexInTile(x, y)];
  if (count < UINT16_MAX) ++count;
}

FineMap::Densities FineMap::Smooth() const {
  const std::vector<float> bell = HalfBell(kBlur / options_.resolution);
  const int reach = static_cast<int>(bell.size()) - 1;
  const int peak_reach = static_cast<int>(std::ceil(kPeakReach / options_.resolution));
  const int margin = reach + peak_reach;
  const int side = kTileCells + 2 * margin;
  const auto at = [side](int x, int y) {
    return static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x);
  };
  // A tile and a margin around it: the counts, blurred along the rows, and blurred both ways.
  std::vector<Density> counts(static_cast<size_t>(side) * static_cast<size_t>(side));
  std::vector<Density> rows(counts.size());
  std::vector<Density> blurred(counts.size());
  const auto blur = [&bell, reach](const std::vector<Density>& from, size_t middle, size_t step) {
    Density sum{bell[0] * from[middle].solid, bell[0] * from[middle].ground, 0.0f};
    for (int i = 1; i <= reach; ++i) {
      const size_t offset = static_cast<size_t>(i) * step;
      const Density& before = from[middle - offset];
      const Density& after = from[middle + offset];
      sum.solid += bell[static_cast<size_t>(i)] * (before.solid + after.solid);
      sum.ground += bell[static_cast<size_t>(i)] * (before.ground + after.ground);
    }
    return sum;
  };
  Densities densities(tiles_.size());
  for (size_t t = 0; t < tiles_.size(); ++t) {
    if (tiles_[t] == nullptr) continue;
    const int left = static_cast<int>(t % static_cast<size_t>(tiles_x_)) * kTileCells - margin;
    const int bottom = static_cast<int>(t / static_cast<size_t>(tiles_x_)) * kTileCells - margin;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        Density& density = counts[at(x, y)];
        density = {};
        if (!IsInside(left + x, bottom + y)) continue;
        const Tile* tile = tiles_[TileIndex(left + x, bottom + y)].get();
        if (tile == nullptr) continue;
        const size_t index = IndexInTile(left + x, bottom + y);
        density = {static_cast<float>(tile->solid[index]), static_cast<float>(tile->ground[index]), 0.0f};
      }
    }
    for (int y = 0; y < side; ++y) {
      for (int x = reach; x < side - reach; ++x) rows[at(x, y)] = blur(counts, at(x, y), 1);
    }
    for (int y = reach; y < side - reach; ++y) {
      for (int x = reach; x < side - reach; ++x) blurred[at(x, y)] = blur(rows, at(x, y), static_cast<size_t>(side));
    }
    // The highest of the surroundings, first of the column's, then of the columns beside it.
    for (int y = margin; y < side - margin; ++y) {
      for (int x = reach; x < side - reach; ++x) {
        float& highest = rows[at(x, y)].solid;
        highest = 0.0f;
        for (int i = -peak_reach; i <= peak_reach; ++i) highest = std::max(highest, blurred[at(x, y + i)].solid);
      }
    }
    densities[t] = std::make_unique<std::array<Density, kTileArea>>();
    for (int y = margin; y < side - margin; ++y) {
      for (int x = margin; x < side - margin; ++x) {
        Density& density = (*densities[t])[IndexInTile(left + x, bottom + y)];
        density = blurred[at(x, y)];
        for (int i = -peak_reach; i <= peak_reach; ++i) density.peak = std::max(density.peak, rows[at(x + i, y)].solid);
      }
    }
  }
  return densities;
}

FineMap::Density FineMap::DensityAt(const Densities& densities, int x, int y) const {
  const auto& tile = densities[TileIndex(x, y)];
  return tile == nullptr ? Density{} : (*tile)[IndexInTile(x, y)];
}

GridImage FineMap::Image() const {
  GridImage image;
  image.width = width_;
  image.height = height_;
  image.resolution = options_.resolution;
  image.origin_x = evidence_.origin_x;
  image.origin_y = evidence_.origin_y;
  image.occupancy.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
  const Densities densities = Smooth();
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      uint8_t& value = image.occupancy[IndexInImage(x, y)];
      value = EvidenceAt(x, y);
      const Tile* tile = tiles_[TileIndex(x, y)].get();
      if (tile == nullptr || !tile->is_near[IndexInTile(x, y)]) continue;
      const Density density = DensityAt(densities, x, y);
      if (density.peak < kFewHits && density.ground < kFewHits) {
        if (value != GridImage::kUnknown && value > kOccupied) value = 100;
      } else if (density.solid > density.ground && density.solid >= std::max(kFewHits, kPeakShare * density.peak)) {
        value = 100;
      } else if (value != GridImage::kUnknown && value > kOccupied) {
        value = 0;
      }
    }
  }
  if (options_.max_round_size == 0.0) return image;

  std::vector<bool> seen(image.occupancy.size(), false);
  std::vector<std::vector<Cell>> components;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (image.occupancy[IndexInImage(x, y)] != 100 || seen[IndexInImage(x, y)]) continue;
      components.push_back(Component({x, y}, image, &seen));
    }
  }
  for (const std::vector<Cell>& component : components) RoundOff(component, densities, &image);
  return image;
}

std::vector<FineMap::Cell> FineMap::Component(const Cell& first, const GridImage& image,
                                              std::vector<bool>* seen) const {
  const int gap = std::max(1, static_cast<int>(std::round(2.0 * kGap / options_.resolution)));
  std::vector<Cell> component{first};
  (*seen)[IndexInImage(first.x, first.y)] = true;
  for (size_t i = 0; i < component.size(); ++i) {
    const Cell cell = component[i];
    for (int y = std::max(0, cell.y - gap); y <= std::min(height_ - 1, cell.y + gap); ++y) {
      for (int x = std::max(0, cell.x - gap); x <= std::min(width_ - 1, cell.x + gap); ++x) {
        const size_t index = IndexInImage(x, y);
        if (image.occupancy[index] != 100 || (*seen)[index]) continue;
        (*seen)[index] = true;
        component.push_back({x, y});
      }
    }
  }
  return component;
}

void FineMap::RoundOff(const std::vector<Cell>& component, const Densities& densities, GridImage* image) const {
  const double max_cells = options_.max_round_size / options_.resolution;
  Cell low = component.front();
  Cell high = component.front();
  for (const Cell& cell : component) {
    low = {std::min(low.x, cell.x), std::min(low.y, cell.y)};
    high = {std::max(high.x, cell.x), std::max(high.y, cell.y)};
  }
  if (std::max(high.x - low.x, high.y - low.y) + 1 > max_cells) return;
  std::vector<Eigen::Vector2d> centers;
  centers.reserve(component.size());
  for (const Cell& cell : component) centers.emplace_back(cell.x + 0.5, cell.y + 0.5);
  const Circle circle = EnclosingCircle(std::move(centers));
  const int first_y = std::max(0, static_cast<int>(std::floor(circle.center.y() - circle.radius)));
  const int last_y = std::min(height_ - 1, static_cast<int>(std::floor(circle.center.y() + circle.radius)));
  const int first_x = std::max(0, static_cast<int>(std::floor(circle.center.x() - circle.radius)));
  const int last_x = std::min(width_ - 1, static_cast<int>(std::floor(circle.center.x() + circle.radius)));
  for (int y = first_y; y <= last_y; ++y) {
    for (int x = first_x; x <= last_x; ++x) {
      if ((Eigen::Vector2d(x + 0.5, y + 0.5) - circle.center).norm() > circle.radius) continue;
      const Density density = DensityAt(densities, x, y);
      if (density.ground <= density.solid + kFewHits) image->occupancy[IndexInImage(x, y)] = 100;
    }
  }
}

}  // namespace arborslam
