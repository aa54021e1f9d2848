#include "frontend/projection/canopy_height.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/simulation/random.h"

namespace arborslam {
namespace {

// Returns evenly between two heights.
void Add(double low, double high, double range, Random* random, CanopyHeight* canopy) {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> heights;
  for (int i = 0; i < 3000; ++i) {
    heights.push_back(static_cast<float>(i % 3 == 0 ? 0.1 * random->Uniform() : random->Uniform(low, high)));
    points.emplace_back(static_cast<float>(range), 0.0f, heights.back());
  }
  canopy->Add(points, heights);
}

TEST(CanopyHeightTest, IsTheMeanHeightOfWhatStandsAboveTheGround) {
  Random random(1);
  CanopyHeight canopy;
  EXPECT_EQ(canopy.Get(), CanopyHeight::kInitial);
  Add(0.5, 2.1, 5.0, &random, &canopy);
  EXPECT_NEAR(canopy.Get(), 1.3f, 0.05f);
}

TEST(CanopyHeightTest, StaysWithinItsBounds) {
  Random random(2);
  CanopyHeight low;
  CanopyHeight high;
  for (int i = 0; i < 5; ++i) {
    Add(0.3, 0.4, 5.0, &random, &low);
    Add(3.0, 3.9, 5.0, &random, &high);
  }
  EXPECT_EQ(low.Get(), CanopyHeight::kLeast);
  EXPECT_EQ(high.Get(), CanopyHeight::kMost);
}

TEST(CanopyHeightTest, ChangesSlowly) {
  Random random(3);
  CanopyHeight canopy;
  for (int i = 0; i < 60; ++i) Add(0.5, 1.5, 5.0, &random, &canopy);
  EXPECT_NEAR(canopy.Get(), 1.0f, 0.05f);
  Add(1.5, 2.1, 5.0, &random, &canopy);
  EXPECT_NEAR(canopy.Get(), 1.0f, 0.1f);
  for (int i = 0; i < 300; ++i) Add(1.5, 2.1, 5.0, &random, &canopy);
  EXPECT_NEAR(canopy.Get(), 1.8f, 0.05f);
}

TEST(CanopyHeightTest, LeavesOutWhatIsFarOrNothing) {
  Random random(4);
  CanopyHeight canopy;
  Add(1.5, 2.1, 50.0, &random, &canopy);
  canopy.Add({}, {});
  EXPECT_EQ(canopy.Get(), CanopyHeight::kInitial);
}

}  // namespace
}  // namespace arborslam
