#include "core/map/distance_field.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>

namespace arborslam {
namespace {

// An occupied cell as it is seen from one column: `across` cells away along x, in row `y`.
struct Sighting {
  int y;
  int across;
  int32_t point;
};

// The distance, in the metric's whole steps, of a cell that is `across` and `along` away.
int Steps(DistanceMetric metric, int across, int along) {
  return metric == DistanceMetric::kL1 ? across + std::abs(along) : across * across + along * along;
}

// The first row from which `later` is at least as near as `earlier` (earlier.y < later.y), or a huge value when there
// is none.
int TakeOverRow(DistanceMetric metric, const Sighting& earlier, const Sighting& later) {
  const int gap = later.y - earlier.y;
  if (metric == DistanceMetric::kL1) {
    const int excess = later.across - earlier.across;
    if (excess > gap) return std::numeric_limits<int>::max();
    if (excess <= -gap) return std::numeric_limits<int>::min();
    // earlier.across + (y - earlier.y) >= later.across + (later.y - y)
    const int twice = excess + later.y + earlier.y;
    return (twice >= 0 ? twice + 1 : twice) / 2;
  }
  // Parabolas: across^2 + (y - y_i)^2. A map may be so long that the square of its rows is no int.
  const int64_t excess = later.across * later.across - earlier.across * earlier.across;
  const int64_t numerator = excess + static_cast<int64_t>(gap) * (later.y + earlier.y);
  const int64_t denominator = 2 * static_cast<int64_t>(gap);
  return static_cast<int>(numerator >= 0 ? (numerator + denominator - 1) / denominator : -((-numerator) / denominator));
}

}  // namespace

DistanceField::DistanceField(const std::vector<Eigen::Vector2f>& points, double cell_size, double max_distance,
                             DistanceMetric metric)
    : cell_size_(static_cast<float>(cell_size)),
      inverse_cell_size_(static_cast<float>(1.0 / cell_size)),
      max_distance_(static_cast<float>(max_distance)) {
  CHECK_GT(cell_size, 0.0);
  CHECK_GE(max_distance, 0.0);
  const double reach = max_distance / cell_size + 1e-6;  // [cells], rounding forgiven.
  const int radius = static_cast<int>(std::floor(reach));
  CHECK_LE(radius, 150) << "max_distance is too many cells";
  const int max_steps = metric == DistanceMetric::kL1 ? radius : static_cast<int>(std::floor(reach * reach));
  metres_.resize(static_cast<size_t>(max_steps) + 2, max_distance_);
  for (int steps = 0; steps <= max_steps; ++steps) {
    const double cells = metric == DistanceMetric::kL1 ? steps : std::sqrt(static_cast<double>(steps));
    metres_[static_cast<size_t>(steps)] = static_cast<float>(std::min(cells * cell_size, max_distance));
  }
  if (points.empty()) return;

  struct Cell {
    int x;
    int y;
    int32_t point;
  };
  std::vector<Cell> cells(points.size());
  int last_x = std::numeric_limits<int>::min();
  int last_y = last_x;
  first_x_ = first_y_ = std::numeric_limits<int>::max();
  for (size_t i = 0; i < points.size(); ++i) {
    const int x = static_cast<int>(std::floor(points[i].x() * inverse_cell_size_));
    const int y = static_cast<int>(std::floor(points[i].y() * inverse_cell_size_));
    cells[i] = {x, y, static_cast<int32_t>(i)};
    first_x_ = std::min(first_x_, x);
    first_y_ = std::min(first_y_, y);
    last_x = std::max(last_x, x);
    last_y = std::max(last_y, y);
  }
  first_x_ -= radius;
  first_y_ -= radius;
  width_ = last_x + radius - first_x_ + 1;
  height_ = last_y + radius - first_y_ + 1;
  const size_t num_cells = static_cast<size_t>(width_) * static_cast<size_t>(height_);
  too_far_ = static_cast<uint16_t>(max_steps + 1);
  nearest_.reset(new int32_t[num_cells]);
  steps_.assign(num_cells, too_far_);

  for (Cell& cell : cells) {
    cell.x -= first_x_;
    cell.y -= first_y_;
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return a.y != b.y ? a.y < b.y : a.x != b.x ? a.x < b.x : a.point < b.point;
  });
  cells.erase(
      std::unique(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.x == b.x && a.y == b.y; }),
      cells.end());

  // First pass, along the rows: which occupied cell of its row does a column see nearest? Twice the same walk, to count
  // and then to fill, so that the sightings of a column lie together, in the order of their rows.
  const auto for_each_sighting = [&](const auto& visit) {
    for (size_t i = 0; i < cells.size(); ++i) {
      const Cell& cell = cells[i];
      const bool follows = i > 0 && cells[i - 1].y == cell.y;
      const bool leads = i + 1 < cells.size() && cells[i + 1].y == cell.y;
      const int from = std::max(cell.x - radius, follows ? (cells[i - 1].x + cell.x) / 2 + 1 : 0);
      const int to = std::min(cell.x + radius, leads ? (cell.x + cells[i + 1].x) / 2 : width_ - 1);
      for (int x = from; x <= to; ++x) visit(x, Sighting{cell.y, std::abs(x - cell.x), cell.point});
    }
  };
  std::vector<size_t> column_end(static_cast<size_t>(width_) + 1, 0);
  for_each_sighting([&](int x, const Sighting&) { ++column_end[static_cast<size_t>(x) + 1]; });
  for (size_t x = 1; x < column_end.size(); ++x) column_end[x] += column_end[x - 1];
  std::vector<Sighting> sightings(column_end.back());
  std::vector<size_t> fill(column_end.begin(), column_end.end() - 1);
  for_each_sighting([&](int x, const Sighting& sighting) { sightings[fill[static_cast<size_t>(x)]++] = sighting; });

  // Second pass, along the columns: the lower envelope of the sightings' distances.
  struct Reign {
    Sighting sighting;
    int from;  // First row in which this sighting is the nearest.
  };
  std::vector<Reign> envelope;
  for (int x = 0; x < width_; ++x) {
    envelope.clear();
    for (size_t i = column_end[static_cast<size_t>(x)]; i < column_end[static_cast<size_t>(x) + 1]; ++i) {
      int from = 0;
      while (!envelope.empty()) {
        from = TakeOverRow(metric, envelope.back().sighting, sightings[i]);
        if (from > envelope.back().from) break;
        envelope.pop_back();
        from = 0;
      }
      if (from < height_) envelope.push_back({sightings[i], from});
    }
    for (size_t i = 0; i < envelope.size(); ++i) {
      const Sighting& sighting = envelope[i].sighting;
      const int end = i + 1 < envelope.size() ? envelope[i + 1].from : height_;
      const int low = std::max(envelope[i].from, sighting.y - radius);
      const int high = std::min(end, sighting.y + radius + 1);
      for (int y = low; y < high; ++y) {
        const int steps = Steps(metric, sighting.across, y - sighting.y);
        if (steps > max_steps) continue;
        nearest_[Index(x, y)] = sighting.point;
        steps_[Index(x, y)] = static_cast<uint16_t>(steps);
      }
    }
  }
}

std::vector<uint8_t> DistanceField::Quantised(int num_steps) const {
  std::vector<uint8_t> quantum(metres_.size(), static_cast<uint8_t>(num_steps));
  for (size_t i = 0; i < metres_.size() && max_distance_ > 0.0f; ++i) {
    quantum[i] = static_cast<uint8_t>(metres_[i] / max_distance_ * static_cast<float>(num_steps));
  }
  std::vector<uint8_t> quantised(steps_.size());
  for (size_t i = 0; i < steps_.size(); ++i) quantised[i] = quantum[steps_[i]];
  return quantised;
}

}  // namespace arborslam
