#include "frontend/projection/moving_object_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/config/validation.h"

namespace arborslam {
namespace {

// Scans that a scan is compared with, evenly spread over the history.
constexpr size_t kNumReferences = 6;
// Before this many there is no vote.
constexpr size_t kMinReferences = 2;
// [m], edge of the cells that points are gathered in to vote together,
constexpr double kCellSize = 0.15;
// and how many cells on the next of the same thing may lie.
constexpr int kGap = 2;
// Fewer points are noise, or leaves.
constexpr double kMinPoints = 3.0;
// Of the votes that a thing could get, those that it must get.
constexpr double kMinKnownShare = 0.35;
// Cells that something left behind, to be taken for a mover's.
constexpr int kMinLeftPlaces = 2;
// Where a mover was before: [m] that it is wide, [m/s] that it goes, [m] that is looked at most.
constexpr double kMoverWidth = 0.5;
constexpr double kMaxSpeed = 1.5;
constexpr double kMaxReach = 3.0;
// [m], what keeps its place beside the moving robot keeps it this well,
constexpr double kCompanionSway = 0.4;
// [m], which says something once the robot has moved this far.
constexpr double kCompanionPath = 0.4;
// [m] between the places of the robot that are kept, and how many are.
constexpr double kPathSpacing = 0.1;
constexpr size_t kMaxPathPlaces = 100;

// The points of a scan within a small square.
struct Cell {
  int x = 0;  // Of the lattice.
  int y = 0;
  size_t num_points = 0;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  // [m, base frame], mean of the points.
  std::array<Sight, kNumReferences> sights{};        // What each reference saw there.
  bool is_on_path = false;                           // The robot's own body was there.
  double free_votes = 0.0;
  double standing_votes = 0.0;
};

// The cells of the points within a range of the sensor, in the order of their first points.
class CellGrid {
 public:
  CellGrid(const std::vector<Eigen::Vector2f>& points, double range)
      : half_width_(static_cast<int>(std::ceil(range / kCellSize)) + kGap + 1),
        width_(2 * half_width_ + 1),
        index_(static_cast<size_t>(width_) * static_cast<size_t>(width_), kNone),
        cell_of_point_(points.size(), kNone) {
    const auto squared_range = static_cast<float>(range * range);
    for (size_t i = 0; i < points.size(); ++i) {
      if (!(points[i].squaredNorm() <= squared_range)) continue;
      const Eigen::Vector2d point = points[i].cast<double>();
      const int x = ToLattice(point.x());
      const int y = ToLattice(point.y());
      size_t& index = index_[Slot(x, y)];
      if (index == kNone) {
        index = cells_.size();
        cells_.emplace_back();
        cells_.back().x = x;
        cells_.back().y = y;
      }
      cell_of_point_[i] = index;
      cells_[index].center += point;
      ++cells_[index].num_points;
    }
    for (Cell& cell : cells_) cell.center /= static_cast<double>(cell.num_points);
  }

  std::vector<Cell>& cells() { return cells_; }
  const std::vector<Cell>& cells() const { return cells_; }

  // The points in these cells, ascending.
  std::vector<size_t> PointsIn(const std::vector<size_t>& cells) const {
    std::vector<bool> is_in(cells_.size(), false);
    for (const size_t cell : cells) is_in[cell] = true;
    std::vector<size_t> points;
    for (size_t i = 0; i < cell_of_point_.size(); ++i) {
      if (cell_of_point_[i] != kNone && is_in[cell_of_point_[i]]) points.push_back(i);
    }
    return points;
  }

  // Calls visit(index) for the occupied cells up to `reach` columns and rows from (x, y).
  template <class Visit>
  void VisitAround(int x, int y, int reach, Visit&& visit) const {
    for (int row = std::max(y - reach, -half_width_); row <= std::min(y + reach, half_width_); ++row) {
      for (int column = std::max(x - reach, -half_width_); column <= std::min(x + reach, half_width_); ++column) {
        const size_t index = index_[Slot(column, row)];
        if (index != kNone) visit(index);
      }
    }
  }
  // The same around the place [m, base frame], for all cells whose centres lie within `radius`.
  template <class Visit>
  void VisitAround(const Eigen::Vector2d& place, double radius, Visit&& visit) {
    if (place.cwiseAbs().maxCoeff() > kCellSize * half_width_ + radius) return;
    // A centre lies in its cell, up to half an edge from the middle.
    const int reach = static_cast<int>(std::ceil(radius / kCellSize)) + 1;
    VisitAround(ToLattice(place.x()), ToLattice(place.y()), reach, [&](size_t index) {
      if ((cells_[index].center - place).squaredNorm() < radius * radius) visit(&cells_[index]);
    });
  }

  // Whether there are points at the place [m, base frame] or in the cells next to it.
  bool IsOccupiedAround(const Eigen::Vector2d& place) const {
    bool is_occupied = false;
    VisitAround(ToLattice(place.x()), ToLattice(place.y()), 1, [&](size_t) { is_occupied = true; });
    return is_occupied;
  }

  // The connected cells among those that `belongs(cell)`, as indices.
  template <class Belongs>
  std::vector<std::vector<size_t>> Components(Belongs&& belongs) const {
    std::vector<std::vector<size_t>> components;
    std::vector<bool> is_taken(cells_.size(), false);
    for (size_t seed = 0; seed < cells_.size(); ++seed) {
      if (is_taken[seed] || !belongs(cells_[seed])) continue;
      std::vector<size_t> component = {seed};
      is_taken[seed] = true;
      for (size_t next = 0; next < component.size(); ++next) {
        const Cell& cell = cells_[component[next]];
        VisitAround(cell.x, cell.y, kGap, [&](size_t neighbour) {
          if (is_taken[neighbour] || !belongs(cells_[neighbour])) return;
          is_taken[neighbour] = true;
          component.push_back(neighbour);
        });
      }
      components.push_back(std::move(component));
    }
    return components;
  }

 private:
  static constexpr size_t kNone = std::numeric_limits<size_t>::max();

  static int ToLattice(double coordinate) { return static_cast<int>(std::floor(coordinate / kCellSize)); }
  size_t Slot(int x, int y) const {
    return static_cast<size_t>(y + half_width_) * static_cast<size_t>(width_) + static_cast<size_t>(x + half_width_);
  }

  int half_width_;  // [cells] around the one right and above of the sensor.
  int width_;
  std::vector<size_t> index_;          // Of the cell at each place of the lattice.
  std::vector<size_t> cell_of_point_;  // kNone for points out of range.
  std::vector<Cell> cells_;
};

}  // namespace

std::string MovingObjectOptions::Validate() const {
  if (!(range > 0.0 && range <= 50.0)) return Violation("range", range, "lie in (0, 50] m");
  if (!(history > 0.0)) return Violation("history", history, "be above 0 s");
  if (!(max_size > 0.0)) return Violation("max_size", max_size, "be above 0 m");
  if (!(range_margin > 0.0)) return Violation("range_margin", range_margin, "be above 0 m");
  if (!(side_margin >= 0.0)) return Violation("side_margin", side_margin, "be at least 0 m");
  if (!(min_free_share > 0.0 && min_free_share <= 1.0)) {
    return Violation("min_free_share", min_free_share, "lie in (0, 1]");
  }
  if (!(body_radius >= 0.0)) return Violation("body_radius", body_radius, "be at least 0 m");
  if (!(max_share > 0.0 && max_share <= 1.0)) return Violation("max_share", max_share, "lie in (0, 1]");
  return "";
}

// One scan against the references.
class MovingObjectFilter::Comparison {
 public:
  Comparison(const MovingObjectFilter& filter, const PlanarScan& scan, const SE2& T_odom_base)
      : filter_(filter),
        options_(filter.options_),
        scan_(scan),
        first_returns_(scan),
        grid_(scan.points, filter.options_.range) {
    for (const Reference& reference : filter_.references_) {
      T_reference_base_.push_back(reference.T_odom_base.Inverse() * T_odom_base);
      all_votes_ += Weight(T_reference_base_.size() - 1);
    }
    const SE2 T_base_odom = T_odom_base.Inverse();
    for (const Eigen::Vector2d& body : filter_.path_) {
      grid_.VisitAround(T_base_odom * body, options_.body_radius, [](Cell* cell) { cell->is_on_path = true; });
    }
    for (Cell& cell : grid_.cells()) Vote(&cell);
  }

  std::vector<MovingObject> Find() {
    std::vector<MovingObject> moving;
    size_t num_moving_points = 0;
    // A thing is what hangs together without what stands: someone may pass close by a trunk.
    for (const std::vector<size_t>& thing : grid_.Components([this](const Cell& cell) { return !Stands(cell); })) {
      const auto object = JudgeThing(thing);
      if (!object) continue;
      num_moving_points += object->points.size();
      moving.push_back(*object);
    }
    const auto is_too_much = [this](size_t part, size_t whole) {
      return static_cast<double>(part) > options_.max_share * static_cast<double>(whole);
    };
    if (is_too_much(num_moving_points, scan_.points.size())) return {};
    // Two people may be all there is near by.
    if (moving.size() <= 2) return moving;
    const size_t num_standing = grid_.Components([this](const Cell& cell) { return Stands(cell); }).size();
    if (is_too_much(moving.size(), moving.size() + num_standing)) return {};
    return moving;
  }

 private:
  // A slow mover has not left its place in the last scans: older ones say more.
  double Weight(size_t reference) const { return static_cast<double>(filter_.references_.size() - reference); }

  Sight Look(const FirstReturns& first_returns, const Eigen::Vector2d& place) const {
    return first_returns.Look(place.cast<float>(), static_cast<float>(options_.range_margin),
                              static_cast<float>(options_.side_margin));
  }

  void Vote(Cell* cell) const {
    for (size_t k = 0; k < filter_.references_.size(); ++k) {
      cell->sights[k] = Look(filter_.references_[k].first_returns, T_reference_base_[k] * cell->center);
      if (cell->sights[k] == Sight::kFree) cell->free_votes += Weight(k);
      if (cell->sights[k] == Sight::kOccupied) cell->standing_votes += Weight(k);
    }
    // Nothing that stands can be where the robot's own body was.
    if (cell->is_on_path) cell->free_votes += 2.0 * all_votes_;
  }

  bool IsFree(double free_votes, double standing_votes) const {
    return free_votes >= options_.min_free_share * (free_votes + standing_votes);
  }
  bool Stands(const Cell& cell) const { return !IsFree(cell.free_votes, cell.standing_votes); }

  // What the cells of `thing` show, if it moves.
  std::optional<MovingObject> JudgeThing(const std::vector<size_t>& thing) {
    double num_points = 0.0;
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    double free_votes = 0.0;
    double standing_votes = 0.0;
    std::array<double, kNumReferences> hidden{};  // Points that each reference could not see.
    bool has_left_a_place = false;
    for (const size_t index : thing) {
      const Cell& cell = grid_.cells()[index];
      const auto weight = static_cast<double>(cell.num_points);
      num_points += weight;
      center += weight * cell.center;
      free_votes += weight * cell.free_votes;
      standing_votes += weight * cell.standing_votes;
      for (size_t k = 0; k < filter_.references_.size(); ++k) {
        if (cell.sights[k] == Sight::kHidden) hidden[k] += weight;
      }
      has_left_a_place = has_left_a_place || cell.is_on_path;
    }
    if (num_points < kMinPoints) return std::nullopt;
    center /= num_points;
    double radius = 0.0;
    for (const size_t index : thing) radius = std::max(radius, (grid_.cells()[index].center - center).norm());
    if (2.0 * radius > options_.max_size) return std::nullopt;

    // What touches it and stands speaks against it: it is a crown's fringe.
    standing_votes += StandingVotesAround(thing);
    double hidden_votes = 0.0;
    for (size_t k = 0; k < filter_.references_.size(); ++k) hidden_votes += Weight(k) * hidden[k];
    if (!IsFree(free_votes + hidden_votes, standing_votes)) return std::nullopt;
    for (size_t k = 0; k < filter_.references_.size(); ++k) {
      const LeftPlaces left = CountLeftPlaces(k, center, radius);
      has_left_a_place = has_left_a_place || left.num_near >= kMinLeftPlaces;
      if (left.num_beside < kMinLeftPlaces) continue;
      // Someone who walks ahead of the robot hides the places that he comes to.
      has_left_a_place = true;
      free_votes += Weight(k) * hidden[k];
    }
    if (!has_left_a_place || !IsFree(free_votes, standing_votes) ||
        free_votes + standing_votes < kMinKnownShare * all_votes_ * num_points) {
      return std::nullopt;
    }
    return MovingObject{center.cast<float>(), static_cast<float>(radius), grid_.PointsIn(thing)};
  }

  double StandingVotesAround(const std::vector<size_t>& thing) const {
    std::vector<size_t> around;
    for (const size_t index : thing) {
      const Cell& cell = grid_.cells()[index];
      grid_.VisitAround(cell.x, cell.y, 1, [&](size_t neighbour) {
        if (Stands(grid_.cells()[neighbour])) around.push_back(neighbour);
      });
    }
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    double votes = 0.0;
    for (const size_t index : around) {
      votes += static_cast<double>(grid_.cells()[index].num_points) * grid_.cells()[index].standing_votes;
    }
    return votes;
  }

  // An occupied place of a reference where nothing is seen to stand now.
  struct FormerPlace {
    Eigen::Vector2d then;  // [m, base frame of the reference].
    Eigen::Vector2d now;   // [m, base frame].
    bool is_free;          // Else it is hidden.
  };
  const std::vector<FormerPlace>& FormerPlaces(size_t k) {
    // Only few scans have something in them that makes these worth knowing.
    if (!former_places_[k]) {
      former_places_[k].emplace();
      const SE2 T_base_reference = T_reference_base_[k].Inverse();
      for (const Eigen::Vector2d& then : filter_.references_[k].near_places) {
        const Eigen::Vector2d now = T_base_reference * then;
        const Sight sight = Look(first_returns_, now);
        if (sight == Sight::kFree || sight == Sight::kHidden) {
          former_places_[k]->push_back({then, now, sight == Sight::kFree});
        }
      }
    }
    return *former_places_[k];
  }

  // Occupied places of a reference that are free now.
  struct LeftPlaces {
    int num_near = 0;    // Near where the thing is now.
    int num_beside = 0;  // Where the thing is now as the robot, which has moved, sees it.
  };
  LeftPlaces CountLeftPlaces(size_t k, const Eigen::Vector2d& center, double radius) {
    const double age = std::abs(scan_.stamp - filter_.references_[k].stamp);
    const double reach = std::min(kMoverWidth + kMaxSpeed * age, kMaxReach);
    const bool has_robot_moved = T_reference_base_[k].translation().norm() >= kCompanionPath;
    LeftPlaces left;
    for (const FormerPlace& place : FormerPlaces(k)) {
      const bool is_near = (place.now - center).squaredNorm() <= reach * reach;
      const bool is_beside = has_robot_moved && (place.then - center).squaredNorm() <= kCompanionSway * kCompanionSway;
      if (place.is_free) {
        if (is_near) ++left.num_near;
        if (is_beside) ++left.num_beside;
      } else if (is_near && IsHiddenBy(center, radius, place.now)) {
        // Who walks towards the robot hides where he was before.
        ++left.num_near;
      }
    }
    return left;
  }

  // Whether `place`, without points of its own, lies behind a thing, as seen from the robot.
  bool IsHiddenBy(const Eigen::Vector2d& center, double radius, const Eigen::Vector2d& place) const {
    if (place.norm() > options_.range || place.norm() <= center.norm() || place.dot(center) <= 0.0) return false;
    const double beside = std::abs(place.x() * center.y() - place.y() * center.x()) / center.norm();
    return beside <= radius && !grid_.IsOccupiedAround(place);
  }

  const MovingObjectFilter& filter_;
  const MovingObjectOptions& options_;
  const PlanarScan& scan_;
  FirstReturns first_returns_;
  std::vector<SE2> T_reference_base_;
  std::array<std::optional<std::vector<FormerPlace>>, kNumReferences> former_places_;  // Once they are asked for.
  double all_votes_ = 0.0;                                                             // That a point can get.
  CellGrid grid_;
};

std::vector<MovingObject> MovingObjectFilter::Find(const PlanarScan& scan, const SE2& T_odom_base) const {
  if (!options_.enabled || references_.size() < kMinReferences) return {};
  return Comparison(*this, scan, T_odom_base).Find();
}

void MovingObjectFilter::Add(const PlanarScan& scan, const SE2& T_odom_base) {
  if (!options_.enabled) return;
  const Eigen::Vector2d& place = T_odom_base.translation();
  if (path_.empty() || (place - path_.back()).norm() >= kPathSpacing) path_.push_back(place);
  if (path_.size() > kMaxPathPlaces) path_.pop_front();

  const double spacing = options_.history / static_cast<double>(kNumReferences);
  // A little less, because stamps jitter.
  if (!references_.empty() && std::abs(scan.stamp - references_.back().stamp) < 0.9 * spacing) return;
  Reference reference{scan.stamp, T_odom_base, FirstReturns(scan), {}};
  const CellGrid grid(scan.points, options_.range + kMaxReach);
  for (const Cell& cell : grid.cells()) {
    reference.near_places.push_back(cell.center);
  }
  references_.push_back(std::move(reference));
  if (references_.size() > kNumReferences) references_.pop_front();
}

PlanarScan WithoutMovingObjects(const PlanarScan& scan, const std::vector<MovingObject>& objects) {
  std::vector<bool> is_moving(scan.points.size(), false);
  for (const MovingObject& object : objects) {
    for (const size_t i : object.points) is_moving[i] = true;
  }
  PlanarScan rest = scan;
  rest.points.clear();
  rest.weights.clear();
  rest.phases.clear();
  for (size_t i = 0; i < scan.points.size(); ++i) {
    if (is_moving[i]) {
      if (scan.point_rays_are_free) rest.free_ends.push_back(scan.points[i]);
      continue;
    }
    rest.points.push_back(scan.points[i]);
    if (!scan.weights.empty()) rest.weights.push_back(scan.weights[i]);
    if (!scan.phases.empty()) rest.phases.push_back(scan.phases[i]);
  }
  return rest;
}

}  // namespace arborslam
