#ifndef ARBORSLAM_TESTS_BACKEND_DRIFTED_RUN_H_
#define ARBORSLAM_TESTS_BACKEND_DRIFTED_RUN_H_

#include <Eigen/Core>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "core/geometry/se2.h"
#include "tests/backend/planar_posts.h"

namespace arborslam {

/// Twice along the same line through strewn posts, 1 m a keyframe, in three submaps: keyframes 0 to 9, 9 to 19 and, the
/// second time, 20 to 39.
struct DriftedRun {
  PostsRun run{StrewnPosts(60, 40.0, 3), Path()};

  DriftedRun() {
    run.AddSubmap(0, 9, OccupancyGridOptions());
    run.AddSubmap(9, 19, OccupancyGridOptions());
    run.AddSubmap(20, 39, OccupancyGridOptions());
  }

  /// The second time lies `drift` off, of which the graph knows the standard deviations `sigma` [m, m, rad].
  PoseGraph Graph(const SE2& drift, const Eigen::Vector3d& sigma) const {
    PoseGraph graph;
    for (size_t i = 0; i < run.truth.size(); ++i) {
      graph.AddNode(KeyframeId{static_cast<int>(i)}, i < 20 ? run.truth[i] : drift * run.truth[i]);
    }
    const Eigen::Matrix3d sure = Eigen::Vector3d(1e4, 1e4, 1e6).asDiagonal();
    const auto add = [&](SubmapId from, KeyframeId to, const Eigen::Matrix3d& information) {
      const SE2 motion = graph.Pose(from).Inverse() * graph.Pose(to);
      graph.AddConstraint({from, to, motion, information, Constraint::Kind::kSubmap});
    };
    for (const Submap& submap : run.submaps) {
      graph.AddNode(submap.id, graph.Pose(submap.keyframes.front()));
      for (const KeyframeId member : submap.keyframes) add(submap.id, member, sure);
    }
    // `RelativeUncertainty` believes to know at least that much: 1 m, 1 rad.
    const Eigen::Vector3d variances = sigma.cwiseAbs2();
    add(SubmapId{1}, KeyframeId{20}, variances.cwiseInverse().asDiagonal());
    return graph;
  }

  static std::vector<SE2> Path() {
    std::vector<SE2> path;
    for (int i = 0; i < 20; ++i) path.emplace_back(i - 10.0, 0.0, 0.0);
    for (int i = 0; i < 20; ++i) path.emplace_back(i - 10.0, 0.4, 0.1);
    return path;
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BACKEND_DRIFTED_RUN_H_
