#include "core/map/terrain_map.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace arborslam {
namespace {

// Beyond this weight a cell is known as well as the roughness of the ground allows.
constexpr double kFullWeight = 20.0;
// Weight of the assumption that the ground is level, against a cell of full weight one cell away.
constexpr double kLevelWeight = 0.05;

}  // namespace

int64_t TerrainMap::Index(double coordinate) const { return static_cast<int64_t>(std::floor(coordinate / cell_size_)); }

uint64_t TerrainMap::Key(int64_t x, int64_t y) {
  return (static_cast<uint64_t>(x) << 32) ^ (static_cast<uint64_t>(y) & 0xffffffffu);
}

void TerrainMap::Insert(const Eigen::Vector3d& point, double weight) {
  Cell& cell = cells_[Key(Index(point.x()), Index(point.y()))];
  cell.sum += weight * point;
  cell.weight += weight;
}

std::optional<TerrainMap::Surface> TerrainMap::At(const Eigen::Vector2d& position) const {
  const int64_t x = Index(position.x());
  const int64_t y = Index(position.y());
  // Normal equations of z = a + b u + c v, u and v from `position` in cells.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  bool is_near = false;
  for (int64_t dy = -1; dy <= 1; ++dy) {
    for (int64_t dx = -1; dx <= 1; ++dx) {
      const auto found = cells_.find(Key(x + dx, y + dy));
      if (found == cells_.end()) continue;
      const Eigen::Vector3d mean = found->second.sum / found->second.weight;
      const Eigen::Vector2d offset = (mean.head<2>() - position) / cell_size_;
      const double distance2 = offset.squaredNorm();
      is_near = is_near || distance2 <= 1.0;
      const double weight = std::min(1.0, found->second.weight / kFullWeight) * std::exp(-distance2);
      const Eigen::Vector3d basis(1.0, offset.x(), offset.y());
      information += weight * basis * basis.transpose();
      vector += weight * mean.z() * basis;
    }
  }
  if (!is_near) return std::nullopt;
  information(1, 1) += kLevelWeight * information(0, 0) + 1e-12;
  information(2, 2) += kLevelWeight * information(0, 0) + 1e-12;
  const Eigen::Vector3d plane = information.ldlt().solve(vector);
  return Surface{plane.x(), plane.tail<2>() / cell_size_};
}

}  // namespace arborslam
