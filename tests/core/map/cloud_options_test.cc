#include "core/map/cloud_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace arborslam {
namespace {

using testing::StartsWith;

TEST(CloudOptionsTest, NamesTheKeyThatIsOutOfRange) {
  EXPECT_EQ(CloudOptions().Validate(), "");
  CloudOptions options;
  options.voxel_size = 0.0;
  EXPECT_THAT(options.Validate(), StartsWith("voxel_size is 0.0"));
  options = {};
  options.min_sweeps = 0;
  EXPECT_THAT(options.Validate(), StartsWith("min_sweeps is 0"));
  options = {};
  options.min_range = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(options.Validate(), StartsWith("min_range"));
  options = {};
  options.max_range = options.min_range;
  EXPECT_THAT(options.Validate(), StartsWith("max_range"));
  options = {};
  options.every_nth_sweep = -1;
  EXPECT_THAT(options.Validate(), StartsWith("every_nth_sweep"));
  options = {};
  options.max_voxels = 8;
  EXPECT_THAT(options.Validate(), StartsWith("max_voxels"));
}

}  // namespace
}  // namespace arborslam
