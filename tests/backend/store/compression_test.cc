#include "backend/store/compression.h"

#include <gtest/gtest.h>

#include <string>

#include "core/error.h"

namespace arborslam {
namespace {

TEST(Compression, UnpacksWhatItPacked) {
  Compressor compressor;
  for (const std::string& bytes : {std::string(), std::string("a"), std::string(100000, 'x')}) {
    const std::string frame = compressor.Compress(bytes);
    EXPECT_EQ(Decompress(frame, "file"), bytes);
  }
  EXPECT_LT(compressor.Compress(std::string(100000, 'x')).size(), 1000u);
}

TEST(Compression, NoticesAnyDamage) {
  std::string bytes;
  for (int i = 0; i < 300; ++i) bytes += std::to_string(i * i);
  const std::string frame = Compressor().Compress(bytes);
  for (size_t i = 0; i < frame.size(); ++i) {
    std::string damaged = frame;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    try {
      // Some bits of the header say nothing about the content.
      EXPECT_EQ(Decompress(damaged, "file"), bytes) << i;
    } catch (const UserError&) {
    }
    EXPECT_THROW(Decompress(std::string_view(frame).substr(0, i), "file"), UserError) << i;
  }
  EXPECT_THROW(Decompress("no frame", "file"), UserError);
}

}  // namespace
}  // namespace arborslam
