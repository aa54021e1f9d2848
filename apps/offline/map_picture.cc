#include "apps/offline/map_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace arborslam {
namespace {

// [pixels], a longer side is reduced.
constexpr int kMaxSide = 4000;
// [pixels], a shorter one is enlarged.
constexpr int kMinSide = 800;

using Colour = std::array<uint8_t, 3>;
constexpr Colour kUnknownColour{205, 207, 210};
constexpr std::array<Colour, 5> kPaths{{{30, 100, 220}, {230, 130, 0}, {140, 60, 200}, {0, 150, 150}, {200, 60, 130}}};
constexpr Colour kStart{20, 160, 70};
constexpr Colour kEnd{215, 40, 40};

// [pixels] of a map drawn at `pixels_per_cell`.
int PixelsFor(int cells, double pixels_per_cell) {
  return std::max(1, static_cast<int>(std::ceil(cells * pixels_per_cell)));
}

// The shade of a pixel, `row` counted from the bottom; nothing where the map is unknown. The darkest known cell under
// the pixel decides, so that thin trunks survive a reduction.
std::optional<uint8_t> ShadeOf(const GridImage& map, int column, int row, double pixels_per_cell) {
  const auto first = [&](int pixel) { return static_cast<int>(pixel / pixels_per_cell); };
  const auto last = [&](int pixel, int size) {
    return std::min(size - 1, std::max(first(pixel), static_cast<int>(std::ceil((pixel + 1) / pixels_per_cell)) - 1));
  };
  int occupancy = -1;
  for (int y = first(row); y <= last(row, map.height); ++y) {
    for (int x = first(column); x <= last(column, map.width); ++x) {
      const uint8_t cell =
          map.occupancy[static_cast<size_t>(y) * static_cast<size_t>(map.width) + static_cast<size_t>(x)];
      if (cell != GridImage::kUnknown) occupancy = std::max(occupancy, static_cast<int>(cell));
    }
  }
  if (occupancy < 0) return std::nullopt;
  return static_cast<uint8_t>(255 - 255 * std::clamp(2 * occupancy - 100, 0, 100) / 100);
}

// Of the sides of a picture together, how long a line in it may be.
constexpr double kLongestLine = 10.0;

class Canvas {
 public:
  Canvas(const GridImage& map, double pixels_per_cell) : map_(map), scale_(pixels_per_cell / map.resolution) {
    image_.width = PixelsFor(map.width, pixels_per_cell);
    image_.height = PixelsFor(map.height, pixels_per_cell);
    image_.pixels.resize(3 * static_cast<size_t>(image_.width) * static_cast<size_t>(image_.height));
    for (int row = 0; row < image_.height; ++row) {
      for (int column = 0; column < image_.width; ++column) {
        const std::optional<uint8_t> shade = ShadeOf(map, column, image_.height - 1 - row, pixels_per_cell);
        Set(column, row, shade ? Colour{*shade, *shade, *shade} : kUnknownColour);
      }
    }
  }

  // A filled circle around a point of the map [m], radius in pixels.
  void Dot(const Eigen::Vector2d& point, int radius, const Colour& colour) {
    const int x = static_cast<int>(std::lround((point.x() - map_.origin_x) * scale_));
    const int y = image_.height - 1 - static_cast<int>(std::lround((point.y() - map_.origin_y) * scale_));
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx) {
        if (dx * dx + dy * dy <= radius * radius) Set(x + dx, y + dy, colour);
      }
    }
  }

  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour) {
    // What leads far beyond the picture would take for ever, pixel by pixel.
    const double length = (to - from).norm() * scale_;
    if (length > kLongestLine * (image_.width + image_.height)) return;
    const int steps = static_cast<int>(std::ceil(length)) + 1;
    for (int i = 0; i <= steps; ++i) Dot(from + (to - from) * i / steps, 1, colour);
  }

  RgbImage Take() { return std::move(image_); }

 private:
  void Set(int column, int row, const Colour& colour) {
    if (column < 0 || row < 0 || column >= image_.width || row >= image_.height) return;
    const size_t index =
        3 * (static_cast<size_t>(row) * static_cast<size_t>(image_.width) + static_cast<size_t>(column));
    std::copy(colour.begin(), colour.end(), image_.pixels.begin() + static_cast<ptrdiff_t>(index));
  }

  const GridImage& map_;
  const double scale_;  // [pixels per m]
  RgbImage image_;
};

}  // namespace

GridImage ToGridImage(const OccupancyGrid& grid) {
  int low_x = grid.width(), low_y = grid.height(), high_x = -1, high_y = -1;
  for (int y = 0; y < grid.height(); ++y) {
    for (int x = 0; x < grid.width(); ++x) {
      if (!grid.IsKnown(x, y)) continue;
      low_x = std::min(low_x, x);
      high_x = std::max(high_x, x);
      low_y = std::min(low_y, y);
      high_y = std::max(high_y, y);
    }
  }
  if (high_x < 0) low_x = low_y = high_x = high_y = 0;
  GridImage image;
  image.width = high_x - low_x + 3;
  image.height = high_y - low_y + 3;
  image.resolution = grid.cell_size();
  image.origin_x = grid.origin().x() + (low_x - 1) * grid.cell_size();
  image.origin_y = grid.origin().y() + (low_y - 1) * grid.cell_size();
  image.occupancy.assign(static_cast<size_t>(image.width) * static_cast<size_t>(image.height), GridImage::kUnknown);
  for (int y = low_y; y <= high_y; ++y) {
    for (int x = low_x; x <= high_x; ++x) {
      if (x >= grid.width() || y >= grid.height() || !grid.IsKnown(x, y)) continue;
      const size_t index =
          static_cast<size_t>(y - low_y + 1) * static_cast<size_t>(image.width) + static_cast<size_t>(x - low_x + 1);
      image.occupancy[index] = static_cast<uint8_t>(std::lround(100.0 * ProbabilityOf(grid.LogOdds(x, y))));
    }
  }
  return image;
}

RgbImage DrawMap(const GridImage& map, const std::vector<Trajectory>& trajectories) {
  const int longest = std::max(map.width, map.height);
  const double pixels_per_cell = longest > kMaxSide   ? static_cast<double>(kMaxSide) / longest
                                 : longest < kMinSide ? std::ceil(static_cast<double>(kMinSide) / longest)
                                                      : 1.0;
  Canvas canvas(map, pixels_per_cell);
  for (size_t k = 0; k < trajectories.size(); ++k) {
    const Trajectory& trajectory = trajectories[k];
    for (size_t i = 1; i < trajectory.size(); ++i) {
      canvas.Line(trajectory[i - 1].pose.translation(), trajectory[i].pose.translation(), kPaths[k % kPaths.size()]);
    }
  }
  for (const Trajectory& trajectory : trajectories) {
    if (trajectory.empty()) continue;
    canvas.Dot(trajectory.front().pose.translation(), 6, kStart);
    canvas.Dot(trajectory.back().pose.translation(), 6, kEnd);
  }
  return canvas.Take();
}

MapBackdrop DrawBackdrop(const GridImage& map, int max_side) {
  const double pixels_per_cell = std::min(1.0, static_cast<double>(max_side) / std::max(map.width, map.height));
  MapBackdrop backdrop;
  GreyImage& image = backdrop.image;
  image.width = PixelsFor(map.width, pixels_per_cell);
  image.height = PixelsFor(map.height, pixels_per_cell);
  image.pixels.reserve(static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
  for (int row = image.height - 1; row >= 0; --row) {
    for (int column = 0; column < image.width; ++column) {
      const std::optional<uint8_t> shade = ShadeOf(map, column, row, pixels_per_cell);
      image.pixels.push_back(shade ? static_cast<uint8_t>(*shade / 17 * 17) : kUnknownShade);
    }
  }
  backdrop.metres_per_pixel = map.resolution / pixels_per_cell;
  backdrop.left = map.origin_x;
  backdrop.top = map.origin_y + image.height * backdrop.metres_per_pixel;
  return backdrop;
}

}  // namespace arborslam
