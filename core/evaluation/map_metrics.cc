#include "core/evaluation/map_metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/config/validation.h"
#include "core/error.h"
#include "core/map/distance_field.h"

namespace arborslam {
namespace {

constexpr uint8_t kOccupied = 100;
constexpr uint8_t kFree = 0;
constexpr double kMaxToleranceCells = 150.0;  // What a distance field can hold.
constexpr double kMaxCellRatio = 100.0;
constexpr double kRounding = 1e-6;  // [cells]; centres often lie on the other grid's lines, but for rounding.
constexpr double kMaxIndex = 1e15;  // Metres over a tiny resolution may be more than an integer holds.

// A cell of a grid continued beyond its edges; (0, 0) is the lower left one of the grid itself.
struct Cell {
  int64_t x;
  int64_t y;

  bool operator==(const Cell& other) const { return x == other.x && y == other.y; }
  bool operator<(const Cell& other) const { return y != other.y ? y < other.y : x < other.x; }
};

Cell CellAt(const GridImage& grid, const Eigen::Vector2d& point) {
  const auto index = [&grid](double metres) {
    const double cells = std::floor(metres / grid.resolution + kRounding);
    return static_cast<int64_t>(std::clamp(cells, -kMaxIndex, kMaxIndex));
  };
  return {index(point.x() - grid.origin_x), index(point.y() - grid.origin_y)};
}

Eigen::Vector2d Centre(const GridImage& grid, const Cell& cell) {
  return {grid.origin_x + (static_cast<double>(cell.x) + 0.5) * grid.resolution,
          grid.origin_y + (static_cast<double>(cell.y) + 0.5) * grid.resolution};
}

bool Contains(const GridImage& grid, const Cell& cell) {
  return cell.x >= 0 && cell.y >= 0 && cell.x < grid.width && cell.y < grid.height;
}

// The occupancy of `cell`; unknown beyond the edges.
uint8_t At(const GridImage& grid, const Cell& cell) {
  if (!Contains(grid, cell)) return GridImage::kUnknown;
  return grid.occupancy[static_cast<size_t>(cell.y) * static_cast<size_t>(grid.width) + static_cast<size_t>(cell.x)];
}

// Visits every cell of `grid`, rows along x from the lowest up.
template <class Visit>
void ForEachCell(const GridImage& grid, const Visit& visit) {
  for (Cell cell{0, 0}; cell.y < grid.height; ++cell.y) {
    for (cell.x = 0; cell.x < grid.width; ++cell.x) visit(cell);
  }
}

// E of the header, ascending.
std::vector<Cell> Resample(const GridImage& estimate, const GridImage& reference, const SE2& T_reference_estimate) {
  const SE2 T_estimate_reference = T_reference_estimate.Inverse();
  // Half the side of the box, along the axes, about a moved cell.
  const double reach =
      0.5 * estimate.resolution * (std::abs(T_reference_estimate.cos()) + std::abs(T_reference_estimate.sin()));
  std::vector<Cell> cells;
  ForEachCell(estimate, [&](const Cell& occupied) {
    if (At(estimate, occupied) != kOccupied) return;
    const Eigen::Vector2d centre = T_reference_estimate * Centre(estimate, occupied);
    cells.push_back(CellAt(reference, centre));
    const Cell low = CellAt(reference, centre - Eigen::Vector2d::Constant(reach + kRounding * reference.resolution));
    const Cell high = CellAt(reference, centre + Eigen::Vector2d::Constant(reach + kRounding * reference.resolution));
    for (Cell cell = low; cell.y <= high.y; ++cell.y) {
      for (cell.x = low.x; cell.x <= high.x; ++cell.x) {
        if (CellAt(estimate, T_estimate_reference * Centre(reference, cell)) == occupied) cells.push_back(cell);
      }
    }
  });
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

std::vector<Cell> OccupiedCells(const GridImage& grid) {
  std::vector<Cell> cells;
  ForEachCell(grid, [&](const Cell& cell) {
    if (At(grid, cell) == kOccupied) cells.push_back(cell);
  });
  return cells;
}

// Tells which cells in or about a grid are near a set of cells.
class Neighbourhood {
 public:
  /// @param radius [cells], how far "near" reaches.
  Neighbourhood(const std::vector<Cell>& cells, const GridImage& grid, double radius)
      : margin_(static_cast<int64_t>(std::ceil(radius))), width_(grid.width), height_(grid.height) {
    std::vector<Eigen::Vector2f> points;
    for (const Cell& cell : cells) {
      if (IsAbout(cell)) points.push_back(CentreOf(cell));
    }
    field_ = DistanceField(points, 1.0, radius, DistanceMetric::kL2);
  }

  bool Contains(const Cell& cell) const { return IsAbout(cell) && field_.Nearest(CentreOf(cell)) >= 0; }

 private:
  // Cells further out are near none of the grid's, and would make the field as large as they are far.
  bool IsAbout(const Cell& cell) const {
    return cell.x >= -margin_ && cell.y >= -margin_ && cell.x < width_ + margin_ && cell.y < height_ + margin_;
  }
  // In cells.
  static Eigen::Vector2f CentreOf(const Cell& cell) {
    return {static_cast<float>(cell.x) + 0.5f, static_cast<float>(cell.y) + 0.5f};
  }

  int64_t margin_;
  int64_t width_;
  int64_t height_;
  DistanceField field_;
};

double Share(size_t part, size_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

void CheckArguments(const GridImage& estimate, const GridImage& reference, double tolerance, const std::string& place) {
  const double radius = tolerance / reference.resolution;
  if (!(tolerance >= 0.0 && radius <= kMaxToleranceCells)) {
    throw UserError(place, "the tolerance is " + FormatDouble(tolerance) + " m",
                    "give one from 0 m to 150 of the reference's cells, " +
                        FormatDouble(kMaxToleranceCells * reference.resolution) + " m");
  }
  if (estimate.resolution > kMaxCellRatio * reference.resolution) {
    throw UserError(place,
                    "the map's cells of " + FormatDouble(estimate.resolution) +
                        " m are too coarse for the reference's of " + FormatDouble(reference.resolution) + " m",
                    "give a map whose cells are at most 100 times as long");
  }
}

}  // namespace

MapMetrics CompareMaps(const GridImage& estimate, const GridImage& reference, const SE2& T_reference_estimate,
                       const MapComparisonOptions& options, const std::string& place) {
  CheckArguments(estimate, reference, options.tolerance, place);
  const std::vector<Cell> reference_cells = OccupiedCells(reference);
  if (reference_cells.empty()) {
    throw UserError(place, "the reference map has no occupied cell", "give a reference to be compared with");
  }
  const std::vector<Cell> estimated_cells = Resample(estimate, reference, T_reference_estimate);
  const double radius = options.tolerance / reference.resolution;
  const Neighbourhood near_reference(reference_cells, reference, radius);
  const Neighbourhood near_estimate(estimated_cells, reference, radius);

  MapMetrics metrics;
  metrics.estimated_occupied = estimated_cells.size();
  metrics.reference_occupied = reference_cells.size();
  for (const Cell& cell : estimated_cells) {
    const bool is_inside = Contains(reference, cell);
    if (!is_inside) ++metrics.outside;
    if (near_reference.Contains(cell)) {
      ++metrics.estimated_right;
    } else if (is_inside ? At(reference, cell) == kFree : !options.beyond_is_unknown) {
      ++metrics.false_positives;
    } else {
      ++metrics.unjudged;
    }
  }
  metrics.right = metrics.estimated_right;
  for (const Cell& cell : reference_cells) {
    if (!near_estimate.Contains(cell)) {
      ++metrics.false_negatives;
      continue;
    }
    ++metrics.reference_found;
    if (!std::binary_search(estimated_cells.begin(), estimated_cells.end(), cell)) ++metrics.right;
  }

  const SE2 T_estimate_reference = T_reference_estimate.Inverse();
  auto next_estimated = estimated_cells.begin();
  ForEachCell(reference, [&](const Cell& cell) {
    while (next_estimated != estimated_cells.end() && *next_estimated < cell) ++next_estimated;
    const bool is_estimated = next_estimated != estimated_cells.end() && *next_estimated == cell;
    if (is_estimated || At(reference, cell) != kFree) return;
    const Cell beneath = CellAt(estimate, T_estimate_reference * Centre(reference, cell));
    if (At(estimate, beneath) == kFree) ++metrics.true_negatives;
  });

  const size_t num_right = metrics.right + metrics.true_negatives;
  const size_t num_judged = metrics.estimated_right + metrics.false_positives;
  if (num_judged > 0) metrics.precision = Share(metrics.estimated_right, num_judged);
  metrics.sensitivity = Share(metrics.reference_found, metrics.reference_occupied);
  metrics.accuracy = Share(num_right, num_right + metrics.false_positives + metrics.false_negatives);
  return metrics;
}

const std::vector<MapMetricField>& MapMetricFields() {
  using M = MapMetrics;
  using Value = std::optional<double>;
  static const std::vector<MapMetricField> fields = {
      {"map_precision", "map precision", "m_prec", [](const M& m) -> Value { return m.precision; }},
      {"map_sensitivity", "map sensitivity", "m_sens", [](const M& m) -> Value { return m.sensitivity; }},
      {"map_accuracy", "map accuracy", "m_acc", [](const M& m) -> Value { return m.accuracy; }},
  };
  return fields;
}

}  // namespace arborslam
