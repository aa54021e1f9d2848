#include "core/simulation/row_path.h"

#include <glog/logging.h>

namespace arborslam {

ClosedPath RowPath(const std::vector<int>& lanes, double spacing, double near, double far, double turn_radius) {
  CHECK(!lanes.empty() && lanes.size() % 2 == 0 && lanes[0] == 0);
  std::vector<Eigen::Vector2d> corners = {{0.0, 0.0}};
  for (size_t i = 0; i < lanes.size(); ++i) {
    const double y = lanes[i] * spacing;
    if (i > 0) corners.emplace_back(i % 2 == 0 ? near : far, y);
    corners.emplace_back(i % 2 == 0 ? far : near, y);
  }
  corners.emplace_back(near, 0.0);
  return ClosedPath(corners, turn_radius);
}

}  // namespace arborslam
