#include "core/simulation/closed_path.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"

namespace arborslam {

ClosedPath::ClosedPath(const std::vector<Eigen::Vector2d>& corners, double turn_radius) {
  const size_t n = corners.size();
  struct Corner {
    double turn;     // [rad], positive to the left.
    double radius;   // [m].
    double tangent;  // [m] from the corner to where its arc begins and ends.
  };
  const auto edge = [&](size_t i) -> Eigen::Vector2d { return corners[(i + 1) % n] - corners[i % n]; };
  const auto heading = [&](size_t i) { return std::atan2(edge(i).y(), edge(i).x()); };

  std::vector<Corner> roundings;
  for (size_t i = 0; i < n; ++i) {
    const double turn = AngleDifference(heading(i), heading(i + n - 1));
    const double slope = std::tan(0.5 * std::abs(turn));
    const double room = 0.5 * std::min(edge(i).norm(), edge(i + n - 1).norm());
    const double tangent = std::min(turn_radius * slope, room);
    roundings.push_back({turn, slope > 0.0 ? tangent / slope : 0.0, tangent});
  }
  for (size_t i = 0; i < n; ++i) {
    const Corner& from = roundings[i];
    const Corner& to = roundings[(i + 1) % n];
    const Eigen::Vector2d direction = edge(i).normalized();
    const Eigen::Vector2d line_begin = corners[i] + from.tangent * direction;
    pieces_.push_back({length_, SE2(line_begin.x(), line_begin.y(), heading(i)), 0.0});
    length_ += std::max(0.0, edge(i).norm() - from.tangent - to.tangent);
    if (to.radius > 0.0) {
      const Eigen::Vector2d arc_begin = corners[(i + 1) % n] - to.tangent * direction;
      pieces_.push_back(
          {length_, SE2(arc_begin.x(), arc_begin.y(), heading(i)), std::copysign(1.0 / to.radius, to.turn)});
      length_ += to.radius * std::abs(to.turn);
    }
  }
}

SE2 ClosedPath::At(double distance) const {
  const double wrapped = distance - length_ * std::floor(distance / length_);
  const auto next = std::upper_bound(pieces_.begin() + 1, pieces_.end(), wrapped,
                                     [](double value, const Piece& piece) { return value < piece.begin; });
  const Piece& piece = *(next - 1);
  const double along = wrapped - piece.begin;
  if (piece.curvature == 0.0) return piece.pose * SE2(along, 0.0, 0.0);
  const double turn = along * piece.curvature;
  return piece.pose * SE2(std::sin(turn) / piece.curvature, (1.0 - std::cos(turn)) / piece.curvature, turn);
}

}  // namespace arborslam
