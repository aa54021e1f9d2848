#ifndef ARBORSLAM_CORE_IO_MAP_IO_H_
#define ARBORSLAM_CORE_IO_MAP_IO_H_

#include <cstdint>
#include <string>
#include <vector>

namespace arborslam {

/// An occupancy grid as it is exchanged with other programs.
struct GridImage {
  static constexpr uint8_t kUnknown = 255;

  int width = 0;            ///< [cells] along x.
  int height = 0;           ///< [cells] along y.
  double resolution = 0.0;  ///< [m] a cell.
  double origin_x = 0.0;    ///< [m], the map frame's coordinates of the lower left cell's lower left corner.
  double origin_y = 0.0;    ///< [m]
  /// Per cell the probability of being occupied in percent, 0..100, or kUnknown; width * height, rows along x, row 0
  /// the one of lowest y.
  std::vector<uint8_t> occupancy;
};

/// Writes `grid` in the convention of ROS map_server and nav2, mode "trinary": the YAML file `yaml_path` (named *.yaml
/// or
/// *.yml) and beside it, with the ending .pgm, a picture whose top row is the one of highest y. Cells above 65 % become
/// occupied (0), below 19.6 % free (254), all others unknown (205). Throws `UserError` when a file cannot be written.
/// The grid must have at least one cell, as many as its size says, and finite figures.
void WriteMapServer(const std::string& yaml_path, const GridImage& grid);

/// Reads such a map, of other programs too: binary PGM of 8 bits, any thresholds, `negate`, mode "trinary" or none
/// given. Cells become 100, 0 or kUnknown. Throws `UserError` naming file and key for a missing, unknown or malformed
/// key, a rotated map, another mode, and a picture that is not whole.
GridImage ReadMapServer(const std::string& yaml_path);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_MAP_IO_H_
