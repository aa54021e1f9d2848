#include "core/io/png.h"

#include <cairo/cairo.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/io/atomic_file.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// The picture at `path` as cairo reads it.
RgbImage ReadPng(const std::string& path) {
  cairo_surface_t* const surface = cairo_image_surface_create_from_png(path.c_str());
  EXPECT_EQ(cairo_surface_status(surface), CAIRO_STATUS_SUCCESS);
  RgbImage image;
  image.width = cairo_image_surface_get_width(surface);
  image.height = cairo_image_surface_get_height(surface);
  for (int row = 0; row < image.height; ++row) {
    const uint32_t* const pixels = reinterpret_cast<const uint32_t*>(cairo_image_surface_get_data(surface) +
                                                                     row * cairo_image_surface_get_stride(surface));
    for (int column = 0; column < image.width; ++column) {
      for (const int shift : {16, 8, 0}) image.pixels.push_back(static_cast<uint8_t>(pixels[column] >> shift & 0xff));
    }
  }
  cairo_surface_destroy(surface);
  return image;
}

TEST(Png, PicturesReadBack) {
  const TempFolder folder;
  std::mt19937 random(8);
  RgbImage written{13, 7, {}};
  for (int i = 0; i < 13 * 7 * 3; ++i) written.pixels.push_back(static_cast<uint8_t>(random() & 0xff));
  WritePng(folder.File("a.png"), written);
  EXPECT_THAT(ReadWhole(folder.File("a.png")), StartsWith("\x89PNG\r\n"));
  EXPECT_THAT(folder.Names(), ElementsAre("a.png"));
  const RgbImage read = ReadPng(folder.File("a.png"));
  EXPECT_EQ(read.width, 13);
  EXPECT_EQ(read.height, 7);
  EXPECT_EQ(read.pixels, written.pixels);
}

TEST(Png, GreyPicturesReadBack) {
  const TempFolder folder;
  std::mt19937 random(9);
  GreyImage written{13, 7, {}};
  for (int i = 0; i < 13 * 7; ++i) written.pixels.push_back(static_cast<uint8_t>(random() & 0xff));
  WriteFileAtomically(folder.File("a.png"), EncodePng(written));
  const RgbImage read = ReadPng(folder.File("a.png"));
  EXPECT_EQ(read.width, 13);
  EXPECT_EQ(read.height, 7);
  for (size_t i = 0; i < read.pixels.size(); ++i) EXPECT_EQ(read.pixels[i], written.pixels[i / 3]) << i;
}

TEST(Png, ASidePastTheLimitIsAnError) {
  const TempFolder folder;
  const RgbImage wide{40000, 1, std::vector<uint8_t>(120000)};
  EXPECT_THAT(UserErrorOf([&] { WritePng(folder.File("a.png"), wide); }), HasSubstr("40000 x 1"));
  const RgbImage widest{32767, 1, std::vector<uint8_t>(3 * 32767, 9)};
  WritePng(folder.File("b.png"), widest);
  EXPECT_EQ(ReadPng(folder.File("b.png")).pixels, widest.pixels);
}

TEST(Png, AFileThatCannotBeWrittenIsAnError) {
  const TempFolder folder;
  const std::string path = folder.Write("file", "") + "/a.png";
  const RgbImage pixel{1, 1, {1, 2, 3}};
  EXPECT_THAT(UserErrorOf([&] { WritePng(path, pixel); }), HasSubstr(path));
}

}  // namespace
}  // namespace arborslam
