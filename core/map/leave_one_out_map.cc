#include "core/map/leave_one_out_map.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace arborslam {

LeaveOneOutMap::LeaveOneOutMap(const OccupancyGridOptions& options, const std::vector<SE2>& T_grid_base,
                               const std::vector<std::shared_ptr<const PlanarScan>>& scans)
    : options_(options) {
  CHECK_EQ(T_grid_base.size(), scans.size());
  const double inverse_cell = 1.0 / options.cell_size;
  OccupancyGrid grid(options);
  std::map<std::pair<int64_t, int64_t>, size_t> index_of;
  size_t order = 0;
  for (size_t scan = 0; scan < scans.size(); ++scan) {
    passed_.push_back(grid.Insert(T_grid_base[scan], *scans[scan]));
    for (const Eigen::Vector2f& point : scans[scan]->points) {
      const Eigen::Vector2d position = (T_grid_base[scan] * point.cast<double>()) * inverse_cell;
      const Eigen::Vector2d corner(std::floor(position.x()), std::floor(position.y()));
      const auto x = static_cast<int64_t>(corner.x());
      const auto y = static_cast<int64_t>(corner.y());
      const auto [found, is_new] = index_of.try_emplace({x, y}, cells_.size());
      if (is_new) cells_.push_back({x, y, {}});
      const Eigen::Vector2f offset = (options.cell_size * (position - corner)).cast<float>();
      cells_[found->second].hits.push_back({scan, order++, offset});
    }
  }
  for (Cell& cell : cells_) cell.with_all = Replay(cell, std::nullopt);
}

OccupiedCell LeaveOneOutMap::Replay(const Cell& cell, std::optional<size_t> left_out) const {
  const auto hit_log_odds = static_cast<float>(LogOddsOf(options_.hit_probability));
  const auto miss_log_odds = static_cast<float>(LogOddsOf(options_.miss_probability));
  const auto min_log_odds = static_cast<float>(LogOddsOf(options_.min_probability));
  const auto max_log_odds = static_cast<float>(LogOddsOf(options_.max_probability));
  float log_odds = 0.0f;
  float count = 0.0f;
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  auto hit = cell.hits.begin();
  for (size_t scan = 0; scan < passed_.size(); ++scan) {
    const auto end = std::find_if(hit, cell.hits.end(), [scan](const Hit& one) { return one.scan != scan; });
    if (scan == left_out) {
      hit = end;
    } else if (hit != end) {
      log_odds = std::min(log_odds + hit_log_odds, max_log_odds);
      for (; hit != end; ++hit) {
        sum += hit->offset;
        count += 1.0f;
      }
    } else if (passed_[scan].Has(cell.x, cell.y)) {
      log_odds = std::max(log_odds + miss_log_odds, min_log_odds);
    }
  }
  const Eigen::Vector2d corner =
      Eigen::Vector2d(static_cast<double>(cell.x), static_cast<double>(cell.y)) * options_.cell_size;
  return {(corner + (sum / count).cast<double>()).cast<float>(), log_odds};
}

std::vector<OccupiedCell> LeaveOneOutMap::OccupiedCellsWithout(size_t left_out, float min_log_odds) const {
  const auto is_of_others = [left_out](const Hit& hit) { return hit.scan != left_out; };
  std::vector<std::pair<size_t, OccupiedCell>> in_order;  // With the order of their first hits.
  in_order.reserve(cells_.size());
  std::vector<std::pair<size_t, OccupiedCell>> later;  // Those whose first hit is left out.
  for (const Cell& cell : cells_) {
    const auto first = std::find_if(cell.hits.begin(), cell.hits.end(), is_of_others);
    if (first == cell.hits.end()) continue;
    const bool is_touched = passed_[left_out].Has(cell.x, cell.y) || !std::all_of(first, cell.hits.end(), is_of_others);
    const bool is_later = first != cell.hits.begin();
    const OccupiedCell without = is_later || is_touched ? Replay(cell, left_out) : cell.with_all;
    if (without.log_odds < min_log_odds) continue;
    (is_later ? later : in_order).emplace_back(first->order, without);
  }
  const auto is_before = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::sort(later.begin(), later.end(), is_before);
  const auto middle = static_cast<ptrdiff_t>(in_order.size());
  in_order.insert(in_order.end(), later.begin(), later.end());
  std::inplace_merge(in_order.begin(), in_order.begin() + middle, in_order.end(), is_before);
  std::vector<OccupiedCell> cells;
  cells.reserve(in_order.size());
  for (const auto& [order, cell] : in_order) cells.push_back(cell);
  return cells;
}

}  // namespace arborslam
