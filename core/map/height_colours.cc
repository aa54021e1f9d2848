#include "core/map/height_colours.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace arborslam {
namespace {

constexpr std::array<Colour, 16> kViridis = {{{68, 1, 84},
                                              {72, 26, 108},
                                              {71, 47, 125},
                                              {65, 68, 135},
                                              {57, 86, 140},
                                              {49, 104, 142},
                                              {42, 120, 142},
                                              {35, 136, 142},
                                              {31, 152, 139},
                                              {34, 168, 132},
                                              {53, 183, 121},
                                              {84, 197, 104},
                                              {122, 209, 81},
                                              {165, 219, 54},
                                              {210, 226, 27},
                                              {253, 231, 37}}};

// [m], edge of the cells that the ground is found in.
constexpr double kGroundCell = 2.0;
// Of the heights, what is not worth a colour of its own.
constexpr double kTopPercentile = 0.98;

struct Cell {
  int32_t x;
  int32_t y;
};

Cell CellOf(const Eigen::Vector2d& position) {
  return {static_cast<int32_t>(std::floor(position.x())), static_cast<int32_t>(std::floor(position.y()))};
}

uint64_t KeyOf(const Cell& cell) {
  return (static_cast<uint64_t>(static_cast<uint32_t>(cell.x)) << 32) | static_cast<uint32_t>(cell.y);
}

// The least height of each cell.
using Surface = std::unordered_map<uint64_t, float>;

void Lower(const Cell& cell, float z, Surface* surface) {
  const auto [entry, is_new] = surface->emplace(KeyOf(cell), z);
  if (!is_new) entry->second = std::min(entry->second, z);
}

Surface GroundBelow(const std::vector<Eigen::Vector3f>& points) {
  Surface lowest;
  for (const Eigen::Vector3f& point : points) {
    Lower(CellOf(point.head<2>().cast<double>() / kGroundCell), point.z(), &lowest);
  }
  // A cell may show nothing but a crown: its neighbours then help.
  Surface ground;
  for (const auto& [key, z] : lowest) {
    const Cell cell{static_cast<int32_t>(static_cast<uint32_t>(key >> 32)),
                    static_cast<int32_t>(static_cast<uint32_t>(key))};
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) Lower({cell.x + x, cell.y + y}, z, &ground);
    }
  }
  return ground;
}

}  // namespace

Colour Viridis(double t) {
  const double position = std::clamp(t, 0.0, 1.0) * static_cast<double>(kViridis.size() - 1);
  const size_t low = std::min(static_cast<size_t>(position), kViridis.size() - 2);
  const double fraction = position - static_cast<double>(low);
  Colour colour;
  for (size_t i = 0; i < colour.size(); ++i) {
    colour[i] =
        static_cast<uint8_t>(std::lround((1.0 - fraction) * kViridis[low][i] + fraction * kViridis[low + 1][i]));
  }
  return colour;
}

std::vector<float> HeightsAboveGround(const std::vector<Eigen::Vector3f>& points) {
  const Surface ground = GroundBelow(points);
  std::vector<float> heights;
  heights.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    // Between the centres of four cells, which all have an entry, being neighbours of the point's own.
    const Eigen::Vector2d position = point.head<2>().cast<double>() / kGroundCell - Eigen::Vector2d(0.5, 0.5);
    const Cell cell = CellOf(position);
    const auto z_at = [&](int dx, int dy) { return double{ground.at(KeyOf({cell.x + dx, cell.y + dy}))}; };
    const double right = position.x() - cell.x;
    const double up = position.y() - cell.y;
    const double z = (1.0 - up) * ((1.0 - right) * z_at(0, 0) + right * z_at(1, 0)) +
                     up * ((1.0 - right) * z_at(0, 1) + right * z_at(1, 1));
    heights.push_back(static_cast<float>(point.z() - z));
  }
  return heights;
}

std::vector<Colour> ColourByHeight(const std::vector<Eigen::Vector3f>& points) {
  const std::vector<float> heights = HeightsAboveGround(points);
  if (heights.empty()) return {};
  std::vector<float> sorted = heights;
  const auto top = sorted.begin() + static_cast<ptrdiff_t>(kTopPercentile * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), top, sorted.end());
  // A flat cloud has no heights to tell apart.
  const double scale = 1.0 / std::max<double>(*top, 0.1);
  std::vector<Colour> colours;
  colours.reserve(heights.size());
  for (const float height : heights) colours.push_back(Viridis(height * scale));
  return colours;
}

}  // namespace arborslam
