#ifndef ARBORSLAM_CORE_IO_CLOUD_LAYOUT_H_
#define ARBORSLAM_CORE_IO_CLOUD_LAYOUT_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace arborslam {

/// A field of the points of a file: `count` values of one type side by side.
struct CloudField {
  std::string name;
  char type = 'F';    ///< 'F' floating point, 'I' signed, 'U' unsigned.
  size_t size = 4;    ///< [bytes] of one value: 4 or 8 for 'F', 1, 2, 4 or 8 for the others.
  size_t count = 1;   ///< At least 1.
  size_t offset = 0;  ///< [bytes] from the point's first byte; in text: values from the line's first.
};

/// How the points of a PCD or PLY file are laid out.
struct CloudLayout {
  enum class Encoding {
    kText,              ///< A point a line, numbers apart by white space.
    kBinary,            ///< Points side by side without gaps, little-endian.
    kBigEndian,         ///< The same, big-endian.
    kCompressedColumns  ///< Field by field, LZF: two uint32 (size as it is, size when unpacked) before the data.
  };
  Encoding encoding = Encoding::kText;
  std::vector<CloudField> fields;
  size_t num_points = 0;
  size_t point_size = 0;         ///< [bytes] of a point in binary; in text: values of a line.
  size_t body = 0;               ///< [bytes] from the file's first to its first point's.
  size_t lines_before_body = 0;  ///< Lines of the header.
  size_t lines_to_skip = 0;      ///< In text: lines of other things between the header and the points.
  bool has_more = false;         ///< Other things than points follow.

  /// The field called `name` whatever its case, or null.
  const CloudField* Find(std::string_view name) const;
};

/// True if `contents`, the beginning of a file at least, begin as a PCD or a PLY file does.
bool LooksLikePcd(std::string_view contents);
bool LooksLikePly(std::string_view contents);

/// Reads the header of a PCD file (versions 0.5 to 0.7) or a PLY file (1.0), told apart by their beginning; `contents`
/// is the whole file at `path`. Nothing that it claims is believed: `body` lies within `contents`, sizes do not
/// overflow, and the points that it claims have room in the body (in text: two bytes a value; compressed: as the sizes
/// before the data say). Throws `UserError` naming `path` and what is wrong.
CloudLayout ParseCloudHeader(const std::string& path, std::string_view contents);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_CLOUD_LAYOUT_H_
