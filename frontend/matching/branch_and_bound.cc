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
};

class Search {
 public:
  Search(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points, const SE2& center,
         const SearchWindow& window, const MhdOptions& mhd, double max_cost, const std::optional<Exclusion>& exclusion)
      : points_(points), center_(center), window_(window), mhd_(mhd), exclusion_(exclusion) {
    cell_size_ = target.field().cell_size();
    half_cells_ = static_cast<int>(std::floor(window.translation / cell_size_ + 1e-6));
    half_rotations_ = static_cast<int>(std::floor(window.rotation / window.rotation_step + 1e-6));
    // The coarsest node covers about half the window, so that there is something to prune at the top.
    top_level_ = 0;
    while ((2 << top_level_) <= half_cells_ + 1) ++top_level_;
    pyramid_ = &target.Pyramid(top_level_ + 1);
    best_cost_ = max_cost / pyramid_->metres_per_step();
    num_points_ = static_cast<int>(points.size());
    least_k_ = ChooseK(0, num_points_, mhd);
    first_x_ = target.field().first_x();
    first_y_ = target.field().first_y();
  }

  std::optional<SearchResult> Run() {
    Discretise();
    std::vector<Node> nodes;
    const int size = 1 << top_level_;
    for (int rotation = 0; rotation < num_rotations(); ++rotation) {
      for (int x = -half_cells_; x <= half_cells_; x += size) {
        for (int y = -half_cells_; y <= half_cells_; y += size) {
          Node node{rotation, x, y, top_level_, 0.0};
          node.bound = Score(node);
          if (node.bound < best_cost_) nodes.push_back(node);
        }
      }
    }
    Descend(&nodes);
    if (!found_) return std::nullopt;
    return SearchResult{best_pose_, best_cost_ * pyramid_->metres_per_step(), num_scored_};
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

  // The bound of a node or, at level 0, the cost of a pose [quantisation steps].
  double Score(const Node& node) {
    ++num_scored_;
    constexpr int kFar = MinPyramid::kNumSteps;
    std::array<int, kFar + 1> histogram{};
    const MinPyramid::Level& level = pyramid_->level(node.level);
    const CellOffset* cell = &cells_[static_cast<size_t>(node.rotation) * points_.size()];
    for (int i = 0; i < num_points_; ++i) ++histogram[level.At(cell[i].x + node.x, cell[i].y + node.y)];
    const int k = node.level == 0 ? ChooseK(num_points_ - histogram[kFar], num_points_, mhd_) : least_k_;
    int left = k;
    int64_t sum = 0;
    for (int step = 0; left > 0; ++step) {
      const int count = std::min(left, histogram[static_cast<size_t>(step)]);
      sum += static_cast<int64_t>(count) * step;
      left -= count;
    }
    return static_cast<double>(sum) / k + Penalty(node);
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
      if (node.bound >= best_cost_) return;
      if (node.level == 0) {
        const SE2 pose = Pose(node);
        if (IsExcluded(pose)) continue;
        best_cost_ = node.bound;
        best_pose_ = pose;
        found_ = true;
        continue;
      }
      const int half = 1 << (node.level - 1);
      std::vector<Node> children;
      children.reserve(4);
      for (const int x : {node.x, node.x + half}) {
        for (const int y : {node.y, node.y + half}) {
          if (x > half_cells_ || y > half_cells_) continue;
          Node child{node.rotation, x, y, node.level - 1, 0.0};
          child.bound = Score(child);
          if (child.bound < best_cost_) children.push_back(child);
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
  SE2 best_pose_;
  bool found_ = false;
  int64_t num_scored_ = 0;
};

}  // namespace

double PenaltyOf(const SE2& pose, const SE2& center, const SearchPenalty& penalty) {
  return penalty.per_metre * (pose.translation() - center.translation()).norm() +
         penalty.per_radian * std::abs(AngleDifference(pose.theta(), center.theta()));
}

std::optional<SearchResult> BranchAndBound(const MatchTarget& target, const std::vector<Eigen::Vector2f>& points,
                                           const SE2& center, const SearchWindow& window, const MhdOptions& mhd,
                                           double max_cost, const std::optional<Exclusion>& exclusion) {
  if (points.empty() || target.empty()) return std::nullopt;
  return Search(target, points, center, window, mhd, max_cost, exclusion).Run();
}

}  // namespace arborslam
