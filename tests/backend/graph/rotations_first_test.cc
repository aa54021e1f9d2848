#include "backend/graph/rotations_first.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "tests/backend/random_geometry.h"

namespace arborslam {
namespace {

// Poses on a spiral, each measured from the one before and from the one five before, without any error.
struct Spiral {
  std::vector<SE2> truth;
  std::vector<RelativePose> measurements;

  explicit Spiral(size_t size) {
    Random random(3);
    for (size_t i = 0; i < size; ++i) {
      const double turn = 0.7 * static_cast<double>(i);
      truth.emplace_back(turn * std::cos(turn), turn * std::sin(turn), turn);
      for (const size_t back : {size_t{1}, size_t{5}}) {
        if (i < back) continue;
        measurements.push_back(
            {i - back, i, truth[i - back].Inverse() * truth[i], RandomInformation(&random, 0.1, 0.1)});
      }
    }
  }
};

TEST(RotationsFirst, ExactMeasurementsAreSolvedWithoutAnyGuess) {
  const Spiral spiral(40);
  for (const std::vector<size_t>& held : {std::vector<size_t>{0}, std::vector<size_t>{17, 30}}) {
    std::vector<Eigen::Vector3d> poses(40, Eigen::Vector3d(100.0, -100.0, 2.0));
    for (const size_t i : held) poses[i] = spiral.truth[i].vector();
    const auto solved = SolveRotationsFirst(poses, spiral.measurements, held);
    ASSERT_TRUE(solved);
    for (size_t i = 0; i < 40; ++i) {
      const Eigen::Vector3d& pose = (*solved)[i];
      EXPECT_TRUE(SE2(pose.x(), pose.y(), pose.z()).IsApprox(spiral.truth[i], 1e-6)) << i;
    }
    for (const size_t i : held) EXPECT_EQ((*solved)[i], poses[i]);
  }
}

TEST(RotationsFirst, PositionsAreWeightedByTheirInformation) {
  // Two measurements of one step, thrice as sure in one: 1/4 of the way.
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  const std::vector<RelativePose> measurements{{0, 1, SE2(1.0, 0.0, 0.0), 3.0 * unit},
                                               {1, 0, SE2(-2.0, 0.0, 0.0), unit}};
  const auto solved = SolveRotationsFirst({Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, measurements, {0});
  ASSERT_TRUE(solved);
  EXPECT_NEAR((*solved)[1].x(), 1.25, 1e-12);
}

TEST(RotationsFirst, WhatIsNotJoinedToAHeldPoseIsNotSolved) {
  const std::vector<Eigen::Vector3d> poses(3, Eigen::Vector3d::Zero());
  EXPECT_FALSE(SolveRotationsFirst(poses, {{0, 1, SE2(), Eigen::Matrix3d::Identity()}}, {0}));
  EXPECT_TRUE(SolveRotationsFirst(poses, {}, {0, 1, 2}));
}

}  // namespace
}  // namespace arborslam
