#include "apps/common/version.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace arborslam {
namespace {

TEST(VersionTest, IsTheVersionOfTheProject) {
  std::ifstream file(ARBORSLAM_SOURCE_DIR "/CMakeLists.txt");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find(std::string("project(arborslam VERSION ") + kVersion + " "), std::string::npos);
}

}  // namespace
}  // namespace arborslam
