#ifndef ARBORSLAM_CORE_IO_PNG_H_
#define ARBORSLAM_CORE_IO_PNG_H_

#include <cstdint>
#include <string>
#include <vector>

namespace arborslam {

/// A picture of 8 bits a channel.
struct RgbImage {
  int width = 0;   ///< [pixels]
  int height = 0;  ///< [pixels]
  /// width * height * 3 bytes, red, green, blue; row 0 is the top one, the first pixel its left one.
  std::vector<uint8_t> pixels;
};

/// A picture of one channel of 8 bits.
struct GreyImage {
  int width = 0;                ///< [pixels]
  int height = 0;               ///< [pixels]
  std::vector<uint8_t> pixels;  ///< width * height bytes, row 0 is the top one; 0 is black.
};

/// The bytes of `image` as PNG. It must have at least one pixel, as many as its size says, and no side longer than
/// 32767 pixels.
std::string EncodePng(const GreyImage& image);

/// Writes `image` as PNG. Throws `UserError` when the file cannot be written or a side is longer than 32767 pixels. The
/// image must have at least one pixel and as many bytes as its size says.
void WritePng(const std::string& path, const RgbImage& image);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_PNG_H_
