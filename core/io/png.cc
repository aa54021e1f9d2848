#include "core/io/png.h"

#include <cairo.h>
#include <glog/logging.h>

#include <algorithm>
#include <memory>
#include <ostream>

#include "core/error.h"
#include "core/io/atomic_file.h"

namespace arborslam {
namespace {

constexpr int kMaxSide = 32767;  // cairo's limit for an image surface.

cairo_status_t Append(void* stream, const unsigned char* bytes, unsigned int size) {
  static_cast<std::ostream*>(stream)->write(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;  // A failed write is told, with its reason, by AtomicFile.
}

cairo_status_t AppendToString(void* closure, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

Surface MakeSurface(cairo_format_t format, int width, int height) {
  Surface surface(cairo_image_surface_create(format, width, height), &cairo_surface_destroy);
  CHECK_EQ(cairo_surface_status(surface.get()), CAIRO_STATUS_SUCCESS);
  return surface;
}

}  // namespace

std::string EncodePng(const GreyImage& image) {
  CHECK(image.width > 0 && image.height > 0 && image.width <= kMaxSide && image.height <= kMaxSide);
  const size_t width = static_cast<size_t>(image.width);
  CHECK_EQ(image.pixels.size(), width * static_cast<size_t>(image.height));
  // cairo writes a surface that has nothing but opacity as a grey picture.
  const Surface surface = MakeSurface(CAIRO_FORMAT_A8, image.width, image.height);
  unsigned char* const data = cairo_image_surface_get_data(surface.get());
  const size_t stride = static_cast<size_t>(cairo_image_surface_get_stride(surface.get()));
  for (size_t row = 0; row < static_cast<size_t>(image.height); ++row) {
    std::copy_n(&image.pixels[width * row], width, data + row * stride);
  }
  cairo_surface_mark_dirty(surface.get());
  std::string bytes;
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), &AppendToString, &bytes);
  CHECK_EQ(status, CAIRO_STATUS_SUCCESS) << cairo_status_to_string(status);
  return bytes;
}

void WritePng(const std::string& path, const RgbImage& image) {
  CHECK(image.width > 0 && image.height > 0) << path;
  const size_t width = static_cast<size_t>(image.width);
  const size_t height = static_cast<size_t>(image.height);
  CHECK_EQ(image.pixels.size(), 3 * width * height) << path;
  if (image.width > kMaxSide || image.height > kMaxSide) {
    throw UserError(path,
                    "would be a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                        " pixels, more than " + std::to_string(kMaxSide) + " along a side",
                    "choose a coarser resolution");
  }
  const Surface surface = MakeSurface(CAIRO_FORMAT_RGB24, image.width, image.height);
  unsigned char* const data = cairo_image_surface_get_data(surface.get());
  const size_t stride = static_cast<size_t>(cairo_image_surface_get_stride(surface.get()));
  for (size_t row = 0; row < height; ++row) {
    uint32_t* const target = reinterpret_cast<uint32_t*>(data + row * stride);
    const uint8_t* const source = &image.pixels[3 * width * row];
    for (size_t column = 0; column < width; ++column) {
      const uint8_t* const rgb = source + 3 * column;
      target[column] = static_cast<uint32_t>(rgb[0]) << 16 | static_cast<uint32_t>(rgb[1]) << 8 | rgb[2];
    }
  }
  cairo_surface_mark_dirty(surface.get());

  AtomicFile file(path);
  const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), &Append, &file.stream());
  CHECK_EQ(status, CAIRO_STATUS_SUCCESS) << cairo_status_to_string(status);
  file.Commit();
}

}  // namespace arborslam
