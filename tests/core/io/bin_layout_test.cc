#include "core/io/bin_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/io/kitti_bin.h"
#include "core/simulation/random.h"
#include "tests/core/io/temp_folder.h"

namespace arborslam {
namespace {

using testing::HasSubstr;

// A sweep of `count` points over ground 1 m below, with intensities of 0 to 255 and rings of 0 to 15 in what follows.
std::string Sweep(const BinLayout& layout, size_t count, uint64_t seed) {
  Random random(seed);
  std::string bytes;
  for (size_t i = 0; i < count; ++i) {
    const double bearing = 0.01 * static_cast<double>(i / 16);
    const double range = random.Uniform(1.0, 15.0);
    const double values[6] = {range * std::cos(bearing),   range * std::sin(bearing),
                              random.Uniform(-1.0, 1.0),   std::floor(random.Uniform(0.0, 255.0)),
                              static_cast<double>(i % 16), 1e-4 * static_cast<double>(i)};
    for (size_t k = 0; k < layout.num_values; ++k) {
      std::string raw(layout.value_size, '\0');
      if (layout.value_size == 4) {
        const auto value = static_cast<float>(values[k]);
        std::memcpy(raw.data(), &value, 4);
      } else {
        std::memcpy(raw.data(), &values[k], 8);
      }
      if (layout.is_big_endian) std::reverse(raw.begin(), raw.end());
      bytes += raw;
    }
  }
  return bytes;
}

TEST(BinLayout, IsFoundFromTheValuesOfSeveralSweeps) {
  const TempFolder folder;
  for (size_t num_values = 3; num_values <= 6; ++num_values) {
    for (const size_t size : {4, 8}) {
      for (const bool is_big : {false, true}) {
        const BinLayout layout{num_values, size, is_big};
        std::vector<std::string> paths;
        for (uint64_t seed = 0; seed < 3; ++seed) {
          folder.Write(std::to_string(seed) + ".bin", Sweep(layout, 2000 + 13 * seed, seed));
          paths.push_back(folder.File(std::to_string(seed) + ".bin"));
        }
        EXPECT_EQ(FindBinLayout(paths).Name(), layout.Name());
        const LidarSweep sweep = ReadKittiBin(paths[0], layout);
        ASSERT_EQ(sweep.points.size(), 2000u);
        EXPECT_LT(std::abs(sweep.points[7].z()), 1.0f);
        BinLayout parsed;
        ASSERT_TRUE(ParseBinLayout(layout.Name(), &parsed));
        EXPECT_EQ(parsed.Name(), layout.Name());
      }
    }
  }
}

TEST(BinLayout, KittisIsTakenWhereNothingTells) {
  const TempFolder folder;
  folder.Write("empty.bin", "");
  EXPECT_TRUE(FindBinLayout({folder.File("empty.bin")}).IsKitti());
  folder.Write("few.bin", Sweep({5, 4, false}, 4, 1));
  EXPECT_TRUE(FindBinLayout({folder.File("few.bin")}).IsKitti());
  EXPECT_TRUE(FindBinLayout({folder.File("missing.bin")}).IsKitti());
}

TEST(BinLayout, NoiseIsRefusedWithTheFigures) {
  const TempFolder folder;
  Random random(1);
  std::string noise;
  for (int i = 0; i < 2000; ++i) {
    const uint64_t bits = random.Bits();
    noise.append(reinterpret_cast<const char*>(&bits), sizeof(bits));
  }
  folder.Write("noise.bin", noise);
  try {
    FindBinLayout({folder.File("noise.bin")});
    FAIL() << "noise has a layout";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("% as float32"));
    EXPECT_THAT(error.what(), HasSubstr("input.layout"));
  }
}

TEST(BinLayout, ColumnsOneAfterTheOtherAreRefused) {
  const TempFolder folder;
  const std::string points = Sweep({4, 4, false}, 4000, 1);
  std::string columns;
  for (size_t column = 0; column < 4; ++column) {
    for (size_t i = 0; i < 4000; ++i) columns += points.substr(16 * i + 4 * column, 4);
  }
  folder.Write("columns.bin", columns);
  EXPECT_THROW(FindBinLayout({folder.File("columns.bin")}), UserError);
}

TEST(BinLayout, NamesOfNoLayoutAreNone) {
  BinLayout layout;
  for (const char* name : {"", "auto", "4", "2 x float32", "7 x float32", "4 x float16"}) {
    EXPECT_FALSE(ParseBinLayout(name, &layout)) << name;
  }
}

}  // namespace
}  // namespace arborslam
