// Whether the covariances of a run's final poses can be believed.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "backend/graph/marginals.h"
#include "backend/graph/overlap_discount.h"
#include "backend/slam.h"
#include "core/simulation/planar_orchard.h"

namespace arborslam {
namespace {

// The mean over a run's keyframes of e^T P^-1 e / 3, e being the error of a pose relative to the first one (Bar-Shalom
// et al. 2001): 1 when the covariances P are true.
double MeanNees(const PlanarOrchardOptions& options) {
  const PlanarOrchard orchard(options);
  Slam slam(SlamOptions(), 1);
  std::vector<SE2> truth;
  for (size_t i = 0; i < orchard.NumScans(); ++i) {
    if (slam.AddScan(orchard.Scan(i)).is_keyframe) truth.push_back(orchard.TruePose(i));
  }
  slam.Finish(false);
  std::vector<NodeId> nodes;
  for (const Keyframe& keyframe : slam.keyframes()) nodes.push_back(keyframe.id);
  const std::vector<Eigen::Matrix3d> covariances = MarginalCovariances(DiscountOverlap(slam.graph()), nodes);
  const SE2 T_first_map = slam.graph().Pose(nodes.front()).Inverse();
  double sum = 0.0;
  for (size_t k = 1; k < nodes.size(); ++k) {
    const SE2 true_pose = truth.front().Inverse() * truth[k];
    const Eigen::Vector3d error = (true_pose.Inverse() * T_first_map * slam.graph().Pose(nodes[k])).vector();
    sum += error.dot(covariances[k].inverse() * error) / 3.0;
  }
  return sum / static_cast<double>(nodes.size() - 1);
}

TEST(SlamNees, FinalMarginalsAreHonest) {
  // Half the way round, where few maps overlap, and all of it.
  for (const int num_scans : {250, 0}) {
    PlanarOrchardOptions options;
    options.seed = 7;
    options.num_scans = num_scans;
    const double nees = MeanNees(options);
    EXPECT_GE(nees, 0.5) << num_scans;
    EXPECT_LE(nees, 2.0) << num_scans;
  }
}

}  // namespace
}  // namespace arborslam
