#include "apps/common/error_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace arborslam {
namespace {

TEST(ErrorsJson, HasTheAlignmentAndEveryMetricThatThereIs) {
  TrajectoryMetrics metrics;
  metrics.ate_rmse = 0.25;
  metrics.heading_rms.reset();
  const nlohmann::ordered_json json = ErrorsJson(AlignmentKind::kSe2, metrics);
  EXPECT_EQ(json.at("alignment"), "se2");
  EXPECT_EQ(json.at("ate_se2_rmse_m"), 0.25);
  EXPECT_FALSE(json.contains("heading_rms_rad"));
}

}  // namespace
}  // namespace arborslam
