#include "core/map/occupancy_grid.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace arborslam {
namespace {

// The grid grows by at least this many cells at a time, so that growing stays rare.
constexpr int64_t kGrowthCells = 128;

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

void OccupancyGrid::Insert(const SE2& T_grid_base, const PlanarScan& scan) {
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

  const Eigen::Vector2d first(static_cast<double>(first_x_), static_cast<double>(first_y_));
  for (const Eigen::Vector2d& hit : hits) {
    const Eigen::Vector2d position = hit * inverse_cell - first;
    const int x = static_cast<int>(position.x());
    const int y = static_cast<int>(position.y());
    Cell& cell = cells_[Index(x, y)];
    if (cell.hits < 0) {
      cell.hits = static_cast<int32_t>(hits_.size());
      hits_.push_back({first_x_ + x, first_y_ + y, Eigen::Vector2f::Zero(), 0.0f});
    }
    Hits& sum = hits_[static_cast<size_t>(cell.hits)];
    sum.sum += (options_.cell_size * (position - Eigen::Vector2d(x, y))).cast<float>();
    sum.count += 1.0f;
    if (cell.last_scan == scan_) continue;
    cell.last_scan = scan_;
    cell.log_odds = std::min(cell.log_odds + hit_log_odds_, max_log_odds_);
  }
  const Eigen::Vector2d from = T_grid_base.translation() * inverse_cell - first;
  for (const auto* ends : {&hits, &free_ends}) {
    for (const Eigen::Vector2d& end : *ends) CastRay(from, end * inverse_cell - first);
  }
}

void OccupancyGrid::CastRay(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  // Cell by cell after Amanatides and Woo (1987).
  int x = static_cast<int>(from.x());
  int y = static_cast<int>(from.y());
  const Eigen::Vector2d direction = to - from;
  const int step_x = direction.x() >= 0.0 ? 1 : -1;
  const int step_y = direction.y() >= 0.0 ? 1 : -1;
  const int steps = std::abs(static_cast<int>(to.x()) - x) + std::abs(static_cast<int>(to.y()) - y);
  const double delta_x = direction.x() == 0.0 ? HUGE_VAL : std::abs(1.0 / direction.x());
  const double delta_y = direction.y() == 0.0 ? HUGE_VAL : std::abs(1.0 / direction.y());
  double next_x = direction.x() == 0.0 ? HUGE_VAL : (step_x > 0 ? x + 1 - from.x() : from.x() - x) * delta_x;
  double next_y = direction.y() == 0.0 ? HUGE_VAL : (step_y > 0 ? y + 1 - from.y() : from.y() - y) * delta_y;
  for (int i = 0; i < steps; ++i) {
    Cell& cell = cells_[Index(x, y)];
    if (cell.last_scan != scan_) {
      cell.last_scan = scan_;
      cell.log_odds = std::max(cell.log_odds + miss_log_odds_, min_log_odds_);
    }
    if (next_x < next_y) {
      x += step_x;
      next_x += delta_x;
    } else {
      y += step_y;
      next_y += delta_y;
    }
    // Rounding may lead one cell past the end's row or column, and out of the grid with it.
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  }
}

void OccupancyGrid::Cover(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const int64_t low_x = FloorToInt(low.x() / options_.cell_size) - 1;
  const int64_t low_y = FloorToInt(low.y() / options_.cell_size) - 1;
  const int64_t high_x = FloorToInt(high.x() / options_.cell_size) + 2;
  const int64_t high_y = FloorToInt(high.y() / options_.cell_size) + 2;
  if (width_ > 0 && low_x >= first_x_ && low_y >= first_y_ && high_x <= first_x_ + width_ &&
      high_y <= first_y_ + height_) {
    return;
  }
  int64_t new_first_x = low_x - kGrowthCells;
  int64_t new_first_y = low_y - kGrowthCells;
  int64_t new_end_x = high_x + kGrowthCells;
  int64_t new_end_y = high_y + kGrowthCells;
  if (width_ > 0) {
    new_first_x = low_x < first_x_ ? new_first_x : first_x_;
    new_first_y = low_y < first_y_ ? new_first_y : first_y_;
    new_end_x = high_x > first_x_ + width_ ? new_end_x : first_x_ + width_;
    new_end_y = high_y > first_y_ + height_ ? new_end_y : first_y_ + height_;
  }
  const auto new_width = static_cast<size_t>(new_end_x - new_first_x);
  const auto new_height = static_cast<size_t>(new_end_y - new_first_y);
  std::vector<Cell> grown(new_width * new_height);
  for (int y = 0; y < height_; ++y) {
    const size_t to =
        static_cast<size_t>(y + first_y_ - new_first_y) * new_width + static_cast<size_t>(first_x_ - new_first_x);
    std::copy_n(cells_.begin() + static_cast<ptrdiff_t>(Index(0, y)), width_,
                grown.begin() + static_cast<ptrdiff_t>(to));
  }
  cells_ = std::move(grown);
  first_x_ = new_first_x;
  first_y_ = new_first_y;
  width_ = static_cast<int>(new_width);
  height_ = static_cast<int>(new_height);
}

std::vector<OccupiedCell> OccupancyGrid::OccupiedCells(float min_log_odds) const {
  std::vector<OccupiedCell> cells;
  for (const Hits& hits : hits_) {
    const Cell& cell = cells_[Index(static_cast<int>(hits.x - first_x_), static_cast<int>(hits.y - first_y_))];
    if (cell.log_odds < min_log_odds) continue;
    const Eigen::Vector2d corner =
        Eigen::Vector2d(static_cast<double>(hits.x), static_cast<double>(hits.y)) * options_.cell_size;
    cells.push_back({(corner + (hits.sum / hits.count).cast<double>()).cast<float>(), cell.log_odds});
  }
  return cells;
}

}  // namespace arborslam
