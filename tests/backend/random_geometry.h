#ifndef ARBORSLAM_TESTS_BACKEND_RANDOM_GEOMETRY_H_
#define ARBORSLAM_TESTS_BACKEND_RANDOM_GEOMETRY_H_

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "core/geometry/angles.h"
#include "core/geometry/se2.h"
#include "core/simulation/random.h"

namespace arborslam {

/// A pose within `size` [m] of the origin along each axis, with any heading.
inline SE2 RandomPose(Random* random, double size) {
  const double x = random->Uniform(-size, size);
  const double y = random->Uniform(-size, size);
  return SE2(x, y, random->Uniform(-kPi, kPi));
}

/// A full information matrix of errors of about `translation` [m] and `rotation` [rad].
inline Eigen::Matrix3d RandomInformation(Random* random, double translation, double rotation) {
  Eigen::Matrix3d mixed = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 9; ++i) mixed(i) += 0.2 * random->Gaussian();
  const Eigen::Matrix3d root =
      mixed * Eigen::Vector3d(1.0 / translation, 1.0 / translation, 1.0 / rotation).asDiagonal();
  return root.transpose() * root;
}

/// `pose` with an error of `scale` times the standard deviation that `information` claims.
inline SE2 Disturbed(const SE2& pose, const Eigen::Matrix3d& information, double scale, Random* random) {
  Eigen::Vector3d normal;
  for (int i = 0; i < 3; ++i) normal(i) = scale * random->Gaussian();
  const Eigen::LLT<Eigen::Matrix3d> root(information);
  const Eigen::Vector3d error = root.matrixU().solve(normal);
  return pose * SE2(error.x(), error.y(), error.z());
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BACKEND_RANDOM_GEOMETRY_H_
