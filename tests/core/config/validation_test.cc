#include "core/config/validation.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace arborslam {
namespace {

TEST(FormatDoubleTest, IsShortAndAFloatForEveryReader) {
  EXPECT_EQ(FormatDouble(0.7), "0.7");
  EXPECT_EQ(FormatDouble(20.0), "20.0");
  EXPECT_EQ(FormatDouble(-3.0), "-3.0");
  EXPECT_EQ(FormatDouble(1e-5), "1.0e-05");
  EXPECT_EQ(FormatDouble(1.5e300), "1.5e+300");
  EXPECT_EQ(FormatDouble(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(FormatDouble(-0.0), "-0.0");
  EXPECT_EQ(FormatDouble(std::numeric_limits<double>::infinity()), ".inf");
  EXPECT_EQ(FormatDouble(-std::numeric_limits<double>::infinity()), "-.inf");
  EXPECT_EQ(FormatDouble(std::numeric_limits<double>::quiet_NaN()), ".nan");
}

TEST(FormatDoubleTest, ReadsBackToTheSameBits) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 20000; ++i) {
    const uint64_t bits = random();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof(value));
    if (!std::isfinite(value)) continue;
    EXPECT_EQ(std::strtod(FormatDouble(value).c_str(), nullptr), value);
  }
}

TEST(ViolationTest, BeginsWithTheKey) {
  EXPECT_EQ(Violation("alpha_min", 1.3, "lie in (0, 1]"), "alpha_min is 1.3, must lie in (0, 1]");
  EXPECT_EQ(Violation("max_iterations", 0, "be at least 1"), "max_iterations is 0, must be at least 1");
  EXPECT_EQ(Violation("model", "car", "be 'unicycle' or 'omnidirectional'"),
            "model is 'car', must be 'unicycle' or 'omnidirectional'");
}

}  // namespace
}  // namespace arborslam
