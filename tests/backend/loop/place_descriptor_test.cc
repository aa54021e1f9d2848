#include "backend/loop/place_descriptor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "tests/backend/planar_posts.h"

namespace arborslam {
namespace {

constexpr double kRange = 12.0;

PlaceDescriptor Describe(const std::vector<Eigen::Vector2d>& posts, const SE2& pose, uint64_t seed = 1) {
  Random random(seed);
  return DescribePlace(ScanOfPosts(posts, pose, &random).points, kRange);
}

TEST(PlaceDescriptor, TurningShiftsTheSectorsAndChangesNothingElse) {
  const std::vector<Eigen::Vector2d> posts = StrewnPosts(60, 24.0, 3);
  const PlaceDescriptor place = Describe(posts, SE2(1.0, 2.0, 0.3));
  for (const double turn : {0.0, 0.5, 1.7, -3.0, 2.9}) {
    const PlaceDescriptor turned = Describe(posts, SE2(1.0, 2.0, 0.3 + turn), 2);
    const PlaceSimilarity similarity = ComparePlaces(turned, place);
    EXPECT_GT(similarity.value, 0.8) << turn;
    EXPECT_LE(std::abs(AngleDifference(similarity.yaw, turn)), PlaceDescriptor::kSectorWidth) << turn;
    EXPECT_LT((turned.ring_key - place.ring_key).norm(), 0.1f * place.ring_key.norm()) << turn;
  }
}

TEST(PlaceDescriptor, SurvivesDropOutsAndAStepAside) {
  const std::vector<Eigen::Vector2d> posts = StrewnPosts(60, 24.0, 4);
  const PlaceDescriptor place = Describe(posts, SE2());
  std::vector<Eigen::Vector2d> fewer;
  for (size_t i = 0; i < posts.size(); ++i) {
    if (i % 10 != 0) fewer.push_back(posts[i]);
  }
  const PlaceDescriptor nearby = Describe(fewer, SE2(0.3, -0.2, 0.6));
  const PlaceSimilarity similarity = ComparePlaces(nearby, place);
  EXPECT_LE(std::abs(AngleDifference(similarity.yaw, 0.6)), 2.0 * PlaceDescriptor::kSectorWidth);
  for (const uint64_t other : {11, 12, 13, 14}) {
    EXPECT_GT(similarity.value, ComparePlaces(Describe(StrewnPosts(60, 24.0, other), SE2()), place).value + 0.1);
  }
}

TEST(PlaceDescriptor, ComparesAsEveryShiftInTurnWould) {
  const PlaceDescriptor a = Describe(StrewnPosts(40, 24.0, 5), SE2());
  const PlaceDescriptor b = Describe(StrewnPosts(40, 24.0, 6), SE2());
  float most = 0.0f;
  for (int shift = 0; shift < PlaceDescriptor::kNumSectors; ++shift) {
    float sum = 0.0f;
    for (int sector = 0; sector < PlaceDescriptor::kNumSectors; ++sector) {
      sum += a.bins.col(sector).dot(b.bins.col((sector + shift) % PlaceDescriptor::kNumSectors));
    }
    most = std::max(most, sum);
  }
  EXPECT_NEAR(ComparePlaces(a, b).value, most, 1e-5);
}

TEST(PlaceDescriptor, NothingToSeeIsLikeNothing) {
  const PlaceDescriptor nothing = DescribePlace({}, kRange);
  EXPECT_EQ(ComparePlaces(nothing, nothing).value, 0.0);
  EXPECT_EQ(ComparePlaces(DescribePlace({{20.0f, 0.0f}, {NAN, 1.0f}}, kRange), nothing).value, 0.0);
}

}  // namespace
}  // namespace arborslam
