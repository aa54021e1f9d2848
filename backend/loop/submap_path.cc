#include "backend/loop/submap_path.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nanoflann.hpp>
#include <vector>

namespace arborslam {

// The positions as nanoflann wants them, and what it makes of them.
class SubmapPath::Tree {
 public:
  Tree(const Submap& submap, const PoseGraph& graph) : positions_(PositionsOf(submap, graph)), tree_(2, *this) {
    for (const Eigen::Vector2d& position : positions_) box_.extend(position);
    tree_.buildIndex();
  }

  double DistanceTo(const Eigen::Vector2d& position, double max_distance) const {
    double squared = std::numeric_limits<double>::infinity();
    if (positions_.empty() || box_.exteriorDistance(position) > max_distance) return squared;
    uint32_t nearest = 0;
    tree_.knnSearch(position.data(), 1, &nearest, &squared);
    return std::sqrt(squared);
  }

  size_t kdtree_get_point_count() const { return positions_.size(); }
  double kdtree_get_pt(size_t index, size_t dimension) const {
    return positions_[index](static_cast<Eigen::Index>(dimension));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

 private:
  static std::vector<Eigen::Vector2d> PositionsOf(const Submap& submap, const PoseGraph& graph) {
    std::vector<Eigen::Vector2d> positions;
    for (const KeyframeId member : submap.keyframes) positions.push_back(graph.Pose(member).translation());
    return positions;
  }

  const std::vector<Eigen::Vector2d> positions_;
  Eigen::AlignedBox2d box_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Tree>, Tree, 2> tree_;
};

SubmapPath::SubmapPath(const Submap& submap, const PoseGraph& graph) : tree_(std::make_unique<Tree>(submap, graph)) {}

SubmapPath::SubmapPath(SubmapPath&& other) noexcept = default;

SubmapPath::~SubmapPath() = default;

double SubmapPath::DistanceTo(const Eigen::Vector2d& position, double max_distance) const {
  return tree_->DistanceTo(position, max_distance);
}

}  // namespace arborslam
