#include "core/evaluation/alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "core/geometry/angles.h"

namespace arborslam {
namespace {

Eigen::Matrix3Xd RandomPoints(int count, std::mt19937* random) {
  std::normal_distribution<double> coordinate(0.0, 20.0);
  return Eigen::Matrix3Xd::NullaryExpr(3, count, [&]() { return coordinate(*random); });
}

Eigen::Isometry3d RandomMotion(std::mt19937* random) {
  std::normal_distribution<double> normal;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(normal(*random), normal(*random), normal(*random), normal(*random))
                   .normalized()
                   .toRotationMatrix();
  T.translation() = 1000.0 * Eigen::Vector3d(normal(*random), normal(*random), normal(*random));
  return T;
}

SE2 RandomPlanarMotion(std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return SE2(1000.0 * uniform(*random), 1000.0 * uniform(*random), kPi * uniform(*random));
}

Eigen::Matrix2Xd Moved(const SE2& T, const Eigen::Matrix2Xd& points) {
  return (T.rotation() * points).colwise() + T.translation();
}

Eigen::Matrix3Xd Moved(const Eigen::Isometry3d& T, const Eigen::Matrix3Xd& points) {
  return (T.linear() * points).colwise() + T.translation();
}

void ExpectProperRotation(const Eigen::Isometry3d& T) {
  EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-9);
  EXPECT_LT((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

StampedPose3 PoseAt(double x, double y, double z, double yaw) {
  return {0.0, {x, y, z}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()))};
}

TEST(AlignmentTest, RecoversRandomMotions) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    const Eigen::Matrix3Xd points = RandomPoints(3 + round % 40, &random);
    const SE2 planar = RandomPlanarMotion(&random);
    const Eigen::Matrix2Xd flat = points.topRows<2>();
    EXPECT_TRUE(UmeyamaSe2(flat, Moved(planar, flat)).IsApprox(planar, 1e-8));
    const Eigen::Isometry3d spatial = RandomMotion(&random);
    EXPECT_LT((UmeyamaSe3(points, Moved(spatial, points)).matrix() - spatial.matrix()).norm(), 1e-8);
  }
}

TEST(AlignmentTest, NoNeighbouringMotionFitsNoisyPointsBetter) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 50; ++round) {
    const Eigen::Matrix3Xd from = RandomPoints(10, &random);
    const Eigen::Matrix3Xd to = Moved(RandomMotion(&random), from) + RandomPoints(10, &random);
    const Eigen::Isometry3d best = UmeyamaSe3(from, to);
    ExpectProperRotation(best);
    const double least = (Moved(best, from) - to).squaredNorm();
    const Eigen::Matrix2Xd flat_from = from.topRows<2>();
    const Eigen::Matrix2Xd flat_to = to.topRows<2>();
    const SE2 planar_best = UmeyamaSe2(flat_from, flat_to);
    const double planar_least = (Moved(planar_best, flat_from) - flat_to).squaredNorm();
    for (int i = 0; i < 50; ++i) {
      Eigen::Isometry3d other = Eigen::Isometry3d::Identity();
      const double scale = std::pow(10.0, -(i % 4));
      other.linear() = Eigen::AngleAxisd(scale * normal(random),
                                         Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized())
                           .toRotationMatrix();
      other.translation() = scale * Eigen::Vector3d(normal(random), normal(random), normal(random));
      EXPECT_GE((Moved(best * other, from) - to).squaredNorm(), least * (1.0 - 1e-12));
      const SE2 planar_other(scale * normal(random), scale * normal(random), scale * normal(random));
      EXPECT_GE((Moved(planar_best * planar_other, flat_from) - flat_to).squaredNorm(), planar_least * (1.0 - 1e-12));
    }
  }
}

TEST(AlignmentTest, NeverReflects) {
  std::mt19937 random(3);
  const Eigen::Matrix3Xd points = RandomPoints(20, &random);
  Eigen::Matrix3Xd mirrored = points;
  mirrored.row(2) *= -1.0;
  ExpectProperRotation(UmeyamaSe3(points, mirrored));
  // A planar path leaves the correlation without full rank, which must not turn it into a reflection either.
  Eigen::Matrix3Xd flat = points;
  flat.row(2).setZero();
  const Eigen::Isometry3d T = RandomMotion(&random);
  EXPECT_LT((UmeyamaSe3(flat, Moved(T, flat)).matrix() - T.matrix()).norm(), 1e-8);
}

TEST(AlignmentTest, OnePointAndCoincidentPointsAreOnlyTranslated) {
  for (const int count : {1, 2, 7}) {
    const Eigen::Matrix3Xd from = Eigen::Vector3d(333333.3, 6300000.1, 2.7).replicate(1, count);
    const Eigen::Matrix3Xd to = Eigen::Vector3d(0.1, 4.7, -1.0).replicate(1, count);
    const Eigen::Isometry3d spatial = UmeyamaSe3(from, to);
    EXPECT_TRUE(spatial.linear().isIdentity(0.0)) << count;
    EXPECT_LT((Moved(spatial, from) - to).norm(), 1e-8) << count;
    const SE2 planar = UmeyamaSe2(from.topRows<2>(), to.topRows<2>());
    EXPECT_EQ(planar.theta(), 0.0) << count;
    EXPECT_LT((planar * Eigen::Vector2d(from.col(0).head<2>()) - to.col(0).head<2>()).norm(), 1e-8) << count;
  }
}

TEST(AlignmentTest, CoincidentOnOneSideOnlyMeetsTheCentroid) {
  Eigen::Matrix3Xd line(3, 3);
  line << 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  const Eigen::Matrix3Xd point = Eigen::Vector3d(5.0, 5.0, 5.0).replicate(1, 3);
  const Eigen::Isometry3d T = UmeyamaSe3(point, line);
  EXPECT_TRUE(T.linear().isIdentity(0.0));
  EXPECT_LT((T * Eigen::Vector3d(5.0, 5.0, 5.0) - Eigen::Vector3d(1.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_EQ(UmeyamaSe2(line.topRows<2>(), point.topRows<2>()).theta(), 0.0);
}

TEST(AlignmentTest, BalancedPointsLeaveThePlanarRotationAtZero) {
  Eigen::Matrix2Xd from(2, 4);
  from << 1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, -1.0;
  Eigen::Matrix2Xd mirrored = from;
  mirrored.row(1) *= -1.0;  // Every rotation fits as badly.
  EXPECT_TRUE(UmeyamaSe2(from, mirrored).IsApprox(SE2(), 1e-12));
}

TEST(AlignmentTest, CollinearPointsAreMappedWithoutRoll) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  const Eigen::RowVectorXd along = Eigen::RowVectorXd::LinSpaced(12, -3.0, 8.0);
  for (int round = 0; round < 100; ++round) {
    const double yaw = angle(random);
    const double pitch = 0.4 * angle(random) / kPi;
    const Eigen::Isometry3d truth = Eigen::Translation3d(4.0, -7.0, 1.0) *
                                    Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY());
    const Eigen::Matrix3Xd from = Eigen::Vector3d::UnitX() * along;
    const Eigen::Isometry3d T = UmeyamaSe3(from, Moved(truth, from));
    EXPECT_LT((T.matrix() - truth.matrix()).norm(), 1e-6) << yaw << " " << pitch;
    const Eigen::Matrix2Xd flat = from.topRows<2>();
    const SE2 planar(1.0, 2.0, yaw);
    EXPECT_TRUE(UmeyamaSe2(flat, Moved(planar, flat)).IsApprox(planar, 1e-8));
  }
  // A vertical line has no heading; the rotation must be one nonetheless.
  const Eigen::Matrix3Xd vertical = Eigen::Vector3d::UnitZ() * along;
  const Eigen::Matrix3Xd horizontal = Eigen::Vector3d::UnitY() * along;
  for (const auto& [from, to] : {std::pair(vertical, horizontal), std::pair(horizontal, vertical),
                                 std::pair(vertical, Eigen::Matrix3Xd(-vertical)), std::pair(vertical, vertical)}) {
    const Eigen::Isometry3d T = UmeyamaSe3(from, to);
    ExpectProperRotation(T);
    EXPECT_LT((Moved(T, from) - to).norm(), 1e-9);
  }
}

TEST(AlignmentTest, RefusesNoPointsAndUnequalCounts) {
  EXPECT_THROW(UmeyamaSe2(Eigen::Matrix2Xd(2, 0), Eigen::Matrix2Xd(2, 0)), std::invalid_argument);
  EXPECT_THROW(UmeyamaSe3(Eigen::Matrix3Xd(3, 2), Eigen::Matrix3Xd(3, 3)), std::invalid_argument);
  EXPECT_THROW(Align({}, AlignmentKind::kNone), std::invalid_argument);
}

TEST(AlignmentTest, OriginMakesTheFirstPosesCoincideInThePlane) {
  const std::vector<PosePair> pairs = {{PoseAt(1.0, 2.0, 0.5, 0.3), PoseAt(10.0, -4.0, 9.0, 2.0)},
                                       {PoseAt(3.0, 2.0, 0.5, 0.3), PoseAt(90.0, -4.0, 9.0, 1.0)}};
  const StampedPose3 first = Transform(Align(pairs, AlignmentKind::kOrigin), pairs[0].estimate);
  EXPECT_LT((first.position - Eigen::Vector3d(10.0, -4.0, 0.5)).norm(), 1e-12);
  EXPECT_NEAR(Heading(first.orientation), 2.0, 1e-12);
}

TEST(AlignmentTest, OriginTakesPositionsWithoutOrientationToStartAlongX) {
  // The estimate sets out along its own heading of 0.7; the reference has the identity for want of an orientation.
  const std::vector<PosePair> pairs = {
      {PoseAt(5.0, 5.0, 0.0, 0.7), PoseAt(2.0, 3.0, 0.0, 0.0)},
      {PoseAt(5.0 + std::cos(0.7), 5.0 + std::sin(0.7), 0.0, 0.7), PoseAt(3.0, 3.0, 0.0, 0.0)}};
  const Eigen::Isometry3d T = Align(pairs, AlignmentKind::kOrigin);
  EXPECT_LT((T * pairs[0].estimate.position - Eigen::Vector3d(2.0, 3.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((T * pairs[1].estimate.position - Eigen::Vector3d(3.0, 3.0, 0.0)).norm(), 1e-12);
}

TEST(AlignmentTest, NoneIsTheIdentity) {
  const std::vector<PosePair> pairs = {{PoseAt(1.0, 2.0, 0.5, 0.3), PoseAt(10.0, -4.0, 9.0, 2.0)}};
  EXPECT_TRUE(Align(pairs, AlignmentKind::kNone).matrix().isIdentity(0.0));
}

TEST(AlignmentTest, KindsAndNamesAgree) {
  for (const AlignmentKind kind :
       {AlignmentKind::kNone, AlignmentKind::kOrigin, AlignmentKind::kSe2, AlignmentKind::kSe3}) {
    EXPECT_EQ(ParseAlignmentKind(ToString(kind)), kind);
  }
  EXPECT_FALSE(ParseAlignmentKind("SE2"));
  EXPECT_FALSE(ParseAlignmentKind(""));
}

TEST(AlignmentTest, HeadingIsTheDirectionSeenFromAbove) {
  EXPECT_NEAR(Heading(Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ()))), 1.2, 1e-12);
  const Eigen::Quaterniond tilted = Eigen::AngleAxisd(-2.5, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(Heading(tilted), -2.5, 1e-12);
}

}  // namespace
}  // namespace arborslam
