#ifndef ARBORSLAM_CORE_IO_PLY_H_
#define ARBORSLAM_CORE_IO_PLY_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/map/height_colours.h"

namespace arborslam {

/// Writes a point cloud as a binary little-endian PLY (Turk 1994): a `vertex` element of float x, y, z [m] and, unless
/// `colours` is empty, uchar red, green, blue. `colours` has no entry or one per point; points are finite. Throws
/// `UserError` when the file cannot be written.
void WritePly(const std::string& path, const std::vector<Eigen::Vector3f>& points, const std::vector<Colour>& colours);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_PLY_H_
