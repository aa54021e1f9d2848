#include "frontend/matching/branch_and_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

struct CellOffset {
  int x;
  int y;
};

// All translations of [x, x + 2^level) x [y, y + 2^level) cells, at one rotation.
struct Node {
  int rotation;
  int x;
  int y;
  int level;
  double bound;
  double core_cost;  // [quantisation steps], mean of the least K that any pose has; in a box at most that of any.
  int num_used;      // How many points the bound is the mean of.
};

class Search {
 public:
  Search(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& center,
         const SearchWindow& window, const MhdOptions& mhd, double max_cost, const std::optional<Exclusion>& exclusion,
         const std::optional<SeenOnly>& seen_only)
      : points_(points), center_(center), window_(window), mhd_(mhd), exclusion_(exclusion), seen_only_(seen_only) {
    cell_size_ = target.field().cell_size();
    half_cells_ = static_cast<int>(std::floor(window.translation / cell_size_ + 1e-6));
    half_rotations_ = static_cast<int>(std::floor(window.rotation / window.rotation_step + 1e-6));
    // The coarsest node covers about half the window, so that there is something to prune at the top.
    top_level_ = 0;
    while ((2 << top_level_) <= half_cells_ + 1) ++top_level_;
    num_points_ = static_cast<int>(points.size());
    least_k_ = ChooseK(0, num_points_, mhd);
    if (seen_only_) {
      seen_only_->pyramid->Extend(top_level_ + 1);
      pyramid_ = seen_only_->pyramid;
      const int least_seen = static_cast<int>(std::ceil(seen_only_->min_share * num_points_ - 1e-9));
      least_k_ = std::clamp(least_seen, 1, least_k_);
      max_core_cost_ = seen_only_->max_core_cost / pyramid_->metres_per_step();
    } else {
      pyramid_ = &target.Pyramid(top_level_ + 1);
    }
    best_cost_ = max_cost / pyramid_->metres_per_step();
    first_x_ = pyramid_->first_x();
    first_y_ = pyramid_->first_y();
  }

  std::optional<SearchResult> Run() {
    Discretise();
    std::vector<Node> nodes;
    const int size = 1 << top_level_;
    for (int rotation = 0; rotation < num_rotations(); ++rotation) {
      for (int x = -half_cells_; x <= half_cells_; x += size) {
        for (int y = -half_cells_; y <= half_cells_; y += size) {
          Node node{rotation, x, y, top_level_, 0.0, 0.0, 0};
          Score(&node);
          if (IsPromising(node)) nodes.push_back(node);
        }
      }
    }
    Descend(&nodes);
    if (!found_) return std::nullopt;
    const double step = pyramid_->metres_per_step();
    return SearchResult{best_pose_, best_cost_ * step, best_core_cost_ * step, best_k_, num_scored_};
  }

 private:
  int num_rotations() const { return 2 * half_rotations_ + 1; }
  // 0, 1, -1, 2, -2, ... so that ties fall to the smallest turn.
  double Rotation(int index) const {
    const int steps = index % 2 == 1 ? (index + 1) / 2 : -(index / 2);
    return steps * window_.rotation_step;
  }
  SE2 Pose(const Node& node) const {
    return SE2(center_.x() + node.x * cell_size_, center_.y() + node.y * cell_size_,
               center_.theta() + Rotation(node.rotation));
  }

  // The cell of every point at every rotation, at the window's centre.
  void Discretise() {
    cells_.resize(static_cast<size_t>(num_rotations()) * points_.size());
    const float inverse_cell = static_cast<float>(1.0 / cell_size_);
    auto cell = cells_.begin();
    for (int rotation = 0; rotation < num_rotations(); ++rotation) {
      const double theta = center_.theta() + Rotation(rotation);
      const auto c = static_cast<float>(std::cos(theta)) * inverse_cell;
      const auto s = static_cast<float>(std::sin(theta)) * inverse_cell;
      const auto x = static_cast<float>(center_.x() / cell_size_) - static_cast<float>(first_x_);
      const auto y = static_cast<float>(center_.y() / cell_size_) - static_cast<float>(first_y_);
      for (const Eigen::Vector2f& point : points_) {
        *cell++ = {static_cast<int>(std::floor(c * point.x() - s * point.y() + x)),
                   static_cast<int>(std::floor(s * point.x() + c * point.y() + y))};
      }
    }
  }

  // Finds the bound of a node or, at level 0, the cost of a pose [quantisation steps].
  void Score(Node* node) {
    ++num_scored_;
    std::array<int, 2 * MinPyramid::kUnseen> histogram{};
    const MinPyramid::Level& level = pyramid_->level(node->level);
    const CellOffset* cell = &cells_[static_cast<size_t>(node->rotation) * points_.size()];
    const int shift_x = node->x;
    const int shift_y = node->y;
    const CellOffset* const end = cell + num_points_;
    for (; cell != end; ++cell) ++histogram[level.At(cell->x + shift_x, cell->y + shift_y)];
    int num_seen = num_points_;
    if (seen_only_) num_seen = MergeUnseen(&histogram);
    const int num_near = num_points_ - histogram[MinPyramid::kNumSteps];
    node->num_used = node->level == 0 ? PoseK(num_near, num_seen) : LeastK(num_seen);
    const auto mean_of_least = [&histogram](int k) {
      int left = k;
      int64_t sum = 0;
      for (int step = 0; left > 0; ++step) {
        const int count = std::min(left, histogram[static_cast<size_t>(step)]);
        sum += static_cast<int64_t>(count) * step;
        left -= count;
      }
      return static_cast<double>(sum) / k;
    };
    node->bound = mean_of_least(node->num_used) + Penalty(*node);
    node->core_cost = seen_only_ ? mean_of_least(least_k_) : 0.0;
  }

  bool IsPromising(const Node& node) const { return node.bound < best_cost_ && node.core_cost < max_core_cost_; }

  // Adds the points in windows that were not seen wholly to the others of their distance; returns the number of others.
  int MergeUnseen(std::array<int, 2 * MinPyramid::kUnseen>* histogram) const {
    int num_seen = num_points_;
    for (size_t step = 0; step < MinPyramid::kUnseen; ++step) {
      const int num_unseen = (*histogram)[step + MinPyramid::kUnseen];
      (*histogram)[step] += num_unseen;
      num_seen -= num_unseen;
    }
    return num_seen;
  }

  // The K of a pose.
  int PoseK(int num_near, int num_seen) const {
    const int k = ChooseK(num_near, num_seen, mhd_);
    if (!seen_only_) return k;
    return std::max(least_k_, k <= num_near ? std::min(k, seen_only_->max_near) : k);
  }

  // The least K of the poses in a box, in all of which `num_seen` points are seen.
  int LeastK(int num_seen) const {
    if (!seen_only_) return least_k_;
    return std::max(least_k_, std::min(ChooseK(0, num_seen, mhd_), seen_only_->max_near));
  }

  // The least penalty in a node's box [quantisation steps].
  double Penalty(const Node& node) const {
    const int last = (1 << node.level) - 1;
    const auto nearest = [last](int first) { return std::max({first, -(first + last), 0}); };
    const double x = nearest(node.x);
    const double y = nearest(node.y);
    return (window_.penalty.per_metre * cell_size_ * std::sqrt(x * x + y * y) +
            window_.penalty.per_radian * std::abs(Rotation(node.rotation))) /
           pyramid_->metres_per_step();
  }

  bool IsExcluded(const SE2& pose) const {
    return exclusion_.has_value() &&
           (pose.translation() - exclusion_->pose.translation()).norm() < exclusion_->translation &&
           std::abs(AngleDifference(pose.theta(), exclusion_->pose.theta())) < exclusion_->rotation;
  }

  // Depth first, the most promising node first. `nodes` are of one level.
  void Descend(std::vector<Node>* nodes) {
    std::stable_sort(nodes->begin(), nodes->end(), [](const Node& a, const Node& b) { return a.bound < b.bound; });
    for (const Node& node : *nodes) {
      if (node.bound >= best_cost_ || is_done_) return;
      if (node.level == 0) {
        const SE2 pose = Pose(node);
        if (IsExcluded(pose)) continue;
        best_cost_ = node.bound;
        best_core_cost_ = node.core_cost;
        best_k_ = node.num_used;
        best_pose_ = pose;
        found_ = true;
        is_done_ = exclusion_ && exclusion_->any_will_do;
        continue;
      }
      const int half = 1 << (node.level - 1);
      std::vector<Node> children;
      children.reserve(4);
      for (const int x : {node.x, node.x + half}) {
        for (const int y : {node.y, node.y + half}) {
          if (x > half_cells_ || y > half_cells_) continue;
          Node child{node.rotation, x, y, node.level - 1, 0.0, 0.0, 0};
          Score(&child);
          if (IsPromising(child)) children.push_back(child);
        }
      }
      Descend(&children);
    }
  }

  const std::vector<Eigen::Vector2f>& points_;
  const SE2 center_;
  const SearchWindow window_;
  const MhdOptions mhd_;
  const std::optional<Exclusion>& exclusion_;
  const std::optional<SeenOnly>& seen_only_;
  const MinPyramid* pyramid_ = nullptr;
  double cell_size_ = 0.0;
  int half_cells_ = 0;
  int half_rotations_ = 0;
  int top_level_ = 0;
  int num_points_ = 0;
  int least_k_ = 0;
  int first_x_ = 0;
  int first_y_ = 0;
  std::vector<CellOffset> cells_;
  double best_cost_ = 0.0;  // [quantisation steps]
  double best_core_cost_ = 0.0;
  double max_core_cost_ = std::numeric_limits<double>::infinity();
  int best_k_ = 0;
  SE2 best_pose_;
  bool found_ = false;
  bool is_done_ = false;
  int64_t num_scored_ = 0;
};

}  // namespace

double PenaltyOf(const SE2& pose, const SE2& center, const SearchPenalty& penalty) {
  return penalty.per_metre * (pose.translation() - center.translation()).norm() +
         penalty.per_radian * std::abs(AngleDifference(pose.theta(), center.theta()));
}

std::optional<SearchResult> BranchAndBound(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                                           const SE2& center, const SearchWindow& window, const MhdOptions& mhd,
                                           double max_cost, const std::optional<Exclusion>& exclusion,
                                           const std::optional<SeenOnly>& seen_only) {
  if (points.empty() || target.empty()) return std::nullopt;
  return Search(target, points, center, window, mhd, max_cost, exclusion, seen_only).Run();
}

}  // namespace arborslam
