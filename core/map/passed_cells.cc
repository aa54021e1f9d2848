#include "core/map/passed_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace arborslam {
namespace {

int64_t FloorToInt(double value) { return static_cast<int64_t>(std::floor(value)); }

// Sets the bits of columns `first` to `last` of the row that begins at `row`.
void Fill(uint64_t* row, int first, int last) {
  constexpr int kLastBit = PassedCells::kTileCells - 1;
  int word = first >> PassedCells::kTileBits;
  const int last_word = last >> PassedCells::kTileBits;
  uint64_t bits = ~uint64_t{0} << (first & kLastBit);
  for (; word < last_word; ++word) {
    row[word] |= bits;
    bits = ~uint64_t{0};
  }
  row[word] |= bits & (~uint64_t{0} >> (kLastBit - (last & kLastBit)));
}

// Marks a ray that covers at least as many columns as rows. What it covers of a row is one span, found without looking
// at the rows before, which is much cheaper than to go from cell to cell.
void FillRay(double from_x, double from_y, double to_x, double to_y, size_t words, uint64_t* rows) {
  // All are positive.
  const int x = static_cast<int>(from_x);
  const int y = static_cast<int>(from_y);
  const int end_x = static_cast<int>(to_x);
  const int end_y = static_cast<int>(to_y);
  const int low = std::min(x, end_x);
  const int high = std::max(x, end_x);
  const int step = end_y >= y ? 1 : -1;
  uint64_t* row = rows + static_cast<size_t>(y) * words;
  const ptrdiff_t row_step = step * static_cast<ptrdiff_t>(words);
  int enter = x;
  if (y != end_y) {
    const double slope = (to_x - from_x) / (to_y - from_y);
    const int num_rows = std::abs(end_y - y);
    const double border = step > 0 ? y + 1 : y;  // Which the ray leaves its first row by.
    const double at_border = from_x + (border - from_y) * slope;
    for (int i = 0; i < num_rows; ++i, row += row_step) {
      const int leave = std::clamp(static_cast<int>(at_border + i * (step * slope)), low, high);
      Fill(row, std::min(enter, leave), std::max(enter, leave));
      enter = leave;
    }
  }
  if (enter < end_x) {
    Fill(row, enter, end_x - 1);
  } else if (enter > end_x) {
    Fill(row, end_x + 1, enter);
  }
}

// Exchanges rows and columns (Warren 2013, section 7-3).
void Transpose(std::array<uint64_t, PassedCells::kTileCells>* tile) {
  uint64_t mask = 0x00000000ffffffffu;
  for (size_t half = PassedCells::kTileCells / 2; half != 0; half /= 2, mask ^= mask << half) {
    for (size_t i = 0; i < tile->size(); i = (i + half + 1) & ~half) {
      const uint64_t swapped = (((*tile)[i] >> half) ^ (*tile)[i + half]) & mask;
      (*tile)[i] ^= swapped << half;
      (*tile)[i + half] ^= swapped;
    }
  }
}

}  // namespace

PassedCells::PassedCells(const Eigen::Vector2d& low, const Eigen::Vector2d& high)
    : first_x_((FloorToInt(low.x()) >> kTileBits) * kTileCells),
      first_y_((FloorToInt(low.y()) >> kTileBits) * kTileCells),
      // With one cell of margin, for what rounding may add.
      tiles_x_(static_cast<int>(((FloorToInt(high.x()) + 1 - first_x_) >> kTileBits) + 1)),
      tiles_y_(static_cast<int>(((FloorToInt(high.y()) + 1 - first_y_) >> kTileBits) + 1)),
      rows_(static_cast<size_t>(tiles_x_) * static_cast<size_t>(tiles_y_) * kTileCells, 0) {}

void PassedCells::CastRay(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const Eigen::Vector2d first(static_cast<double>(first_x_), static_cast<double>(first_y_));
  const Eigen::Vector2d start = from - first;
  const Eigen::Vector2d end = to - first;
  if (std::abs(end.x() - start.x()) >= std::abs(end.y() - start.y())) {
    FillRay(start.x(), start.y(), end.x(), end.y(), static_cast<size_t>(tiles_x_), rows_.data());
  } else {
    if (columns_.empty()) columns_.resize(rows_.size(), 0);
    FillRay(start.y(), start.x(), end.y(), end.x(), static_cast<size_t>(tiles_y_), columns_.data());
  }
}

void PassedCells::Finish() {
  if (columns_.empty()) return;
  const auto width = static_cast<size_t>(tiles_x_);
  const auto height = static_cast<size_t>(tiles_y_);
  std::array<uint64_t, kTileCells> tile;
  for (size_t tile_x = 0; tile_x < width; ++tile_x) {
    for (size_t tile_y = 0; tile_y < height; ++tile_y) {
      uint64_t any = 0;
      for (size_t i = 0; i < tile.size(); ++i) {
        tile[i] = columns_[(tile_x * kTileCells + i) * height + tile_y];
        any |= tile[i];
      }
      if (any == 0) continue;
      Transpose(&tile);
      for (size_t i = 0; i < tile.size(); ++i) rows_[(tile_y * kTileCells + i) * width + tile_x] |= tile[i];
    }
  }
  columns_ = {};
}

}  // namespace arborslam
