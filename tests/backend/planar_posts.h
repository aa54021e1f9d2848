#ifndef ARBORSLAM_TESTS_BACKEND_PLANAR_POSTS_H_
#define ARBORSLAM_TESTS_BACKEND_PLANAR_POSTS_H_

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "backend/keyframe.h"
#include "core/geometry/se2.h"
#include "core/map/occupancy_grid.h"
#include "core/map/submap.h"
#include "core/simulation/random.h"

namespace arborslam {

/// A tiny world: posts of 10 cm radius strewn over a square of `size` [m] about the origin.
inline std::vector<Eigen::Vector2d> StrewnPosts(int count, double size, uint64_t seed) {
  Random random(seed);
  std::vector<Eigen::Vector2d> posts;
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(-size / 2.0, size / 2.0);
    posts.emplace_back(x, random.Uniform(-size / 2.0, size / 2.0));
  }
  return posts;
}

/// The scan of the posts within 12 m of `T_map_base`, 15 returns from the near side of each, 5 mm of noise.
inline PlanarScan ScanOfPosts(const std::vector<Eigen::Vector2d>& posts, const SE2& T_map_base, Random* random) {
  PlanarScan scan;
  for (const Eigen::Vector2d& post : posts) {
    const Eigen::Vector2d centre = T_map_base.Inverse() * post;
    if (centre.norm() > 12.0 || centre.norm() < 0.5) continue;
    const double towards = std::atan2(-centre.y(), -centre.x());
    for (int i = -7; i <= 7; ++i) {
      const double angle = towards + 0.18 * i;
      const Eigen::Vector2d noise(0.005 * random->Gaussian(), 0.005 * random->Gaussian());
      const Eigen::Vector2d point = centre + 0.1 * Eigen::Vector2d(std::cos(angle), std::sin(angle)) + noise;
      scan.points.push_back(point.cast<float>());
    }
  }
  return scan;
}

/// A run of keyframes through the posts, and submaps of them.
struct PostsRun {
  std::vector<SE2> truth;
  std::vector<Keyframe> keyframes;
  std::vector<Submap> submaps;

  PostsRun(const std::vector<Eigen::Vector2d>& posts, const std::vector<SE2>& path) : truth(path) {
    Random random(17);
    for (size_t i = 0; i < path.size(); ++i) {
      PlanarScan scan = ScanOfPosts(posts, path[i], &random);
      scan.stamp = static_cast<double>(i);
      keyframes.push_back({KeyframeId{static_cast<int>(i)}, scan, true});
    }
  }

  /// Adds the submap of keyframes `first` to `last`, with its frame at the true pose of the first.
  void AddSubmap(int first, int last, const OccupancyGridOptions& options) {
    OccupancyGrid grid(options);
    Submap submap;
    submap.id = SubmapId{static_cast<int>(submaps.size())};
    const SE2 T_submap_map = truth[static_cast<size_t>(first)].Inverse();
    for (int i = first; i <= last; ++i) {
      grid.Insert(T_submap_map * truth[static_cast<size_t>(i)], *keyframes[static_cast<size_t>(i)].scan.Get());
      submap.keyframes.push_back(KeyframeId{i});
    }
    submap.cells = grid.OccupiedCells(0.0f);
    submaps.push_back(submap);
  }

  /// The pose of a submap's frame.
  const SE2& TruthOf(const Submap& submap) const { return truth[static_cast<size_t>(submap.keyframes.front().value)]; }
};

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BACKEND_PLANAR_POSTS_H_
