#include "core/map/occupied_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

constexpr double kHalfDiagonal = 0.7072;  // [cells], a little more than that of a cell.

// Cells are told by their column and row in the plane.
using Place = Eigen::Matrix<int64_t, 2, 1>;

struct PlaceHash {
  size_t operator()(const Place& place) const {
    const auto x = static_cast<uint64_t>(place.x());
    const auto y = static_cast<uint64_t>(place.y());
    return static_cast<size_t>((x * 0x9E3779B97F4A7C15u + y * 0x632BE59BD9B4E019u) >> 7);
  }
};

// A cell that was hit.
struct HitCell {
  Place place;
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();  // Of the hits' positions relative to the cell's corner [m].
  float count = 0.0f;
  std::vector<uint32_t> scans;  // That hit it, ascending.
};

// The free rays of one scan, by bearing. All in cells.
class Rays {
 public:
  Rays(const Eigen::Vector2d& from, const std::vector<Eigen::Vector2d>& ends, double miss_range)
      : from_(from), reach_(miss_range + kHalfDiagonal) {
    std::vector<Ray> rays;
    std::vector<size_t> bins;
    begins_.fill(0);
    for (const Eigen::Vector2d& end : ends) {
      const Eigen::Vector2d whole = end - from;
      const Eigen::Vector2d ray = std::min(1.0, miss_range / whole.norm()) * whole;
      if (ray.isZero(0.0)) continue;
      rays.push_back({{Inverse(ray.x()), Inverse(ray.y())}});
      bins.push_back(static_cast<size_t>(BinOf(ray)));
      ++begins_[bins.back() + 1];
    }
    for (size_t bin = 1; bin < begins_.size(); ++bin) begins_[bin] += begins_[bin - 1];
    rays_.resize(rays.size());
    std::array<uint32_t, kBins + 1> next = begins_;
    for (size_t i = 0; i < rays.size(); ++i) rays_[next[bins[i]]++] = rays[i];
  }

  // True if a ray passes through the cell, and does not end in it.
  bool Pass(const Place& place) const {
    const Eigen::Vector2d corner = place.cast<double>() - from_;
    const Eigen::Vector2d center = corner + Eigen::Vector2d(0.5, 0.5);
    const double distance = center.norm();
    if (distance > reach_) return false;
    if (distance <= kHalfDiagonal) return AnyPasses(0, kBins, corner);
    const int spread = 1 + static_cast<int>(std::asin(kHalfDiagonal / distance) * kBinsPerRadian);
    const int middle = BinOf(center);
    const int low = middle - spread;
    const int end = middle + spread + 1;
    if (end - low >= kBins) return AnyPasses(0, kBins, corner);
    if (low < 0) return AnyPasses(low + kBins, kBins, corner) || AnyPasses(0, end, corner);
    if (end > kBins) return AnyPasses(low, kBins, corner) || AnyPasses(0, end - kBins, corner);
    return AnyPasses(low, end, corner);
  }

 private:
  struct Ray {
    Eigen::Vector2d inverse;  // Of the way from the base to the ray's end, coordinate by coordinate.
  };
  static constexpr double kTiny = 1e-200;
  static constexpr int kBins = 720;
  static constexpr double kBinsPerRadian = kBins / (2.0 * kPi);

  // Finite also for a ray along an axis.
  static double Inverse(double way) { return 1.0 / (std::abs(way) < kTiny ? std::copysign(kTiny, way) : way); }

  static int BinOf(const Eigen::Vector2d& direction) {
    return std::min(kBins - 1, static_cast<int>((std::atan2(direction.y(), direction.x()) + kPi) * kBinsPerRadian));
  }

  // Of the rays in bins [begin, end); `corner` is the cell's lower one as seen from the base.
  bool AnyPasses(int begin, int end, const Eigen::Vector2d& corner) const {
    for (uint32_t i = begins_[static_cast<size_t>(begin)]; i < begins_[static_cast<size_t>(end)]; ++i) {
      // Shares of the ray at which it crosses the lines that bound the cell (Kay and Kajiya 1986).
      const Eigen::Vector2d& inverse = rays_[i].inverse;
      const double x0 = corner.x() * inverse.x();
      const double x1 = (corner.x() + 1.0) * inverse.x();
      const double y0 = corner.y() * inverse.y();
      const double y1 = (corner.y() + 1.0) * inverse.y();
      const double enter = std::max(std::min(x0, x1), std::min(y0, y1));
      const double leave = std::min(std::max(x0, x1), std::max(y0, y1));
      if (enter < leave && leave > 0.0 && leave <= 1.0) return true;
    }
    return false;
  }

  Eigen::Vector2d from_;
  double reach_;
  std::vector<Ray> rays_;                     // By bins of bearing.
  std::array<uint32_t, kBins + 1> begins_{};  // Where each bin begins in it.
};

}  // namespace

std::vector<OccupiedCell> OccupiedCellsOf(const std::vector<InsertedScan>& scans, const OccupancyGridOptions& options,
                                          float min_log_odds) {
  const double inverse_cell = 1.0 / options.cell_size;
  std::vector<HitCell> hit_cells;
  std::unordered_map<Place, size_t, PlaceHash> index_of;
  std::vector<Rays> rays;
  std::vector<Eigen::Vector2d> ends;
  for (size_t k = 0; k < scans.size(); ++k) {
    const SE2& T_grid_base = scans[k].T_grid_base;
    const PlanarScan& scan = *scans[k].scan;
    ends.clear();
    for (const Eigen::Vector2f& point : scan.points) {
      const Eigen::Vector2d position = T_grid_base * Eigen::Vector2d(point.cast<double>()) * inverse_cell;
      const Eigen::Vector2d corner(std::floor(position.x()), std::floor(position.y()));
      const Place place = corner.cast<int64_t>();
      const auto [entry, is_new] = index_of.emplace(place, hit_cells.size());
      if (is_new) hit_cells.emplace_back().place = place;
      HitCell& cell = hit_cells[entry->second];
      cell.sum += (options.cell_size * (position - corner)).cast<float>();
      cell.count += 1.0f;
      if (cell.scans.empty() || cell.scans.back() != k) cell.scans.push_back(static_cast<uint32_t>(k));
      if (scan.point_rays_are_free) ends.push_back(position);
    }
    for (const Eigen::Vector2f& end : scan.free_ends) {
      ends.push_back(T_grid_base * Eigen::Vector2d(end.cast<double>()) * inverse_cell);
    }
    rays.emplace_back(T_grid_base.translation() * inverse_cell, ends, options.miss_range * inverse_cell);
  }

  const auto hit = static_cast<float>(LogOddsOf(options.hit_probability));
  const auto miss = static_cast<float>(LogOddsOf(options.miss_probability));
  const auto least = static_cast<float>(LogOddsOf(options.min_probability));
  const auto most = static_cast<float>(LogOddsOf(options.max_probability));
  std::vector<OccupiedCell> occupied;
  for (const HitCell& cell : hit_cells) {
    float log_odds = 0.0f;
    auto next_hit = cell.scans.begin();
    for (size_t k = 0; k < scans.size(); ++k) {
      if (next_hit != cell.scans.end() && *next_hit == k) {
        log_odds = std::min(log_odds + hit, most);
        ++next_hit;
      } else if (rays[k].Pass(cell.place)) {
        log_odds = std::max(log_odds + miss, least);
      }
    }
    if (log_odds < min_log_odds) continue;
    const Eigen::Vector2d corner = cell.place.cast<double>() * options.cell_size;
    occupied.push_back({(corner + (cell.sum / cell.count).cast<double>()).cast<float>(), log_odds});
  }
  return occupied;
}

}  // namespace arborslam
