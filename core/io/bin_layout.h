#ifndef ARBORSLAM_CORE_IO_BIN_LAYOUT_H_
#define ARBORSLAM_CORE_IO_BIN_LAYOUT_H_

#include <cstddef>
#include <string>
#include <vector>

namespace arborslam {

/// How the points of a `.bin` file, which has no header, are laid out: x, y, z [m] and further values, one type.
struct BinLayout {
  size_t num_values = 4;  ///< Of a point, 3 to 6; the first three are x, y, z.
  size_t value_size = 4;  ///< [bytes]: 4, float32, or 8, float64.
  bool is_big_endian = false;

  size_t point_size() const { return num_values * value_size; }  ///< [bytes]
  bool IsKitti() const { return num_values == 4 && value_size == 4 && !is_big_endian; }
  /// "4 x float32", "5 x float64, big-endian", as `ParseBinLayout` takes it.
  std::string Name() const;
};

/// The layout of that name; false if there is none.
bool ParseBinLayout(const std::string& name, BinLayout* layout);

/// Finds the layout of the sweeps at `paths`, all of one recording, by what their bytes say together:
/// - the type is the one as which the values are numbers of a plausible size (float64 read as float32 is noise);
/// - the number of values is the one by which columns differ most: read with a wrong one, all columns mix all values.
/// KITTI's layout (4 x float32) is taken unless it is clearly worse than another. Files that are empty or cannot be
/// read are left aside; without any the answer is KITTI's. Throws `UserError` when no type is plausible, or when two
/// layouts are about as good and KITTI's is not among them, with the figures seen.
BinLayout FindBinLayout(const std::vector<std::string>& paths);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_BIN_LAYOUT_H_
