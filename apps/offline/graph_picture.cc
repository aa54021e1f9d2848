#include "apps/offline/graph_picture.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

namespace arborslam {
namespace {

using Colour = std::array<uint8_t, 3>;
constexpr Colour kPath = {30, 80, 200};
constexpr Colour kLoop = {190, 190, 190};
constexpr Colour kDropped = {240, 150, 140};
constexpr Colour kHeld = {20, 150, 60};

constexpr int kLongSide = 1400;  // [pixels], without the margin.
constexpr int kMargin = 20;      // [pixels]
constexpr int kHeldRadius = 5;   // [pixels]

class Canvas {
 public:
  explicit Canvas(const PoseGraph2& graph) {
    Eigen::Vector2d high = graph.vertices.begin()->second.translation();
    low_ = high;
    for (const auto& [id, pose] : graph.vertices) {
      low_ = low_.cwiseMin(pose.translation());
      high = high.cwiseMax(pose.translation());
    }
    const Eigen::Vector2d size = high - low_;
    // A graph without any extent is drawn as if it were a metre large.
    scale_ = kLongSide / std::max(size.maxCoeff(), 1.0);
    image_.width = 2 * kMargin + 1 + static_cast<int>(size.x() * scale_);
    image_.height = 2 * kMargin + 1 + static_cast<int>(size.y() * scale_);
    image_.pixels.assign(3 * static_cast<size_t>(image_.width) * static_cast<size_t>(image_.height), 255);
  }

  void Line(const SE2& from, const SE2& to, const Colour& colour) {
    const Eigen::Vector2d begin = Pixel(from);
    const Eigen::Vector2d step = Pixel(to) - begin;
    const int steps = static_cast<int>(step.cwiseAbs().maxCoeff()) + 1;
    for (int i = 0; i <= steps; ++i) Set(begin + step * i / steps, colour);
  }

  void Dot(const SE2& pose, const Colour& colour) {
    for (int y = -kHeldRadius; y <= kHeldRadius; ++y) {
      for (int x = -kHeldRadius; x <= kHeldRadius; ++x) {
        if (x * x + y * y <= kHeldRadius * kHeldRadius) Set(Pixel(pose) + Eigen::Vector2d(x, y), colour);
      }
    }
  }

  RgbImage Take() { return std::move(image_); }

 private:
  Eigen::Vector2d Pixel(const SE2& pose) const {
    const Eigen::Vector2d place = scale_ * (pose.translation() - low_);
    return {kMargin + place.x(), image_.height - 1 - kMargin - place.y()};
  }

  void Set(const Eigen::Vector2d& pixel, const Colour& colour) {
    const auto column = std::lround(pixel.x());
    const auto row = std::lround(pixel.y());
    if (column < 0 || row < 0 || column >= image_.width || row >= image_.height) return;
    std::copy(colour.begin(), colour.end(), image_.pixels.begin() + 3 * (row * image_.width + column));
  }

  Eigen::Vector2d low_;
  double scale_ = 1.0;  // [pixels per m]
  RgbImage image_;
};

}  // namespace

RgbImage DrawGraph(const PoseGraph2& graph, const std::vector<PoseGraph2::Edge>& dropped,
                   const std::vector<int>& held) {
  Canvas canvas(graph);
  const auto draw = [&](const PoseGraph2::Edge& edge, const Colour& colour) {
    canvas.Line(graph.vertices.at(edge.from), graph.vertices.at(edge.to), colour);
  };
  const auto is_loop = [&graph](const PoseGraph2::Edge& edge) {
    const auto next = std::next(graph.vertices.find(std::min(edge.from, edge.to)));
    return next->first != std::max(edge.from, edge.to);
  };
  for (const PoseGraph2::Edge& edge : dropped) draw(edge, kDropped);
  for (const PoseGraph2::Edge& edge : graph.edges) {
    if (is_loop(edge)) draw(edge, kLoop);
  }
  for (const PoseGraph2::Edge& edge : graph.edges) {
    if (!is_loop(edge)) draw(edge, kPath);
  }
  for (const int id : held) canvas.Dot(graph.vertices.at(id), kHeld);
  return canvas.Take();
}

}  // namespace arborslam
