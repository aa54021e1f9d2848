#ifndef ARBORSLAM_TESTS_BENCHMARK_SIMULATED_RUN_H_
#define ARBORSLAM_TESTS_BENCHMARK_SIMULATED_RUN_H_

#include <Eigen/Core>
#include <vector>

#include "core/geometry/se2.h"
#include "core/map/ids.h"
#include "core/map/occupancy_grid.h"
#include "core/sensor/planar_scan.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"
#include "frontend/matching/match_target.h"
#include "frontend/matching/matcher.h"
#include "frontend/projection/laser_projection.h"
#include "frontend/tracking/constraint.h"
#include "frontend/tracking/tracker.h"

namespace arborslam {

/// A robot's walk through the simulated orchard of default options, none of its scans spoilt.
inline PlanarOrchard BenchmarkOrchard(int num_scans) {
  PlanarOrchardOptions options;
  options.num_scans = num_scans;
  options.spoilt_scans = 0.0;
  return PlanarOrchard(options);
}

/// A scan to be matched, and from where.
struct Query {
  std::vector<Eigen::Vector2f> points;  ///< [m], base frame.
  std::vector<Eigen::Vector2f> sample;  ///< As many of them as the search uses.
  SE2 truth;                            ///< T_map_base.
  SE2 prediction;                       ///< The truth, off by up to 0.2 m and 0.1 rad.
};

/// A submap of ordinary size, with default options throughout: the map of a hundred scans at their true poses along
/// 56 m of path, and the scans between them as queries.
struct MappedOrchard {
  std::vector<PlanarScan> scans;    ///< Those in the map.
  std::vector<SE2> poses;           ///< Theirs, T_map_base.
  OccupancyGrid grid;               ///< The map.
  std::vector<OccupiedCell> cells;  ///< Its occupied cells.
  MatchTarget target;               ///< Made of these.
  std::vector<Query> queries;

  static MappedOrchard Build() {
    constexpr size_t kNumScans = 200;
    const PlanarOrchard orchard = BenchmarkOrchard(kNumScans);
    MappedOrchard mapped{{}, {}, OccupancyGrid(OccupancyGridOptions()), {}, MatchTarget({}, 0.05, 0.2), {}};
    const MatcherOptions matcher;
    Random random(1);
    for (size_t i = 0; i < kNumScans; ++i) {
      const PlanarScan scan = ProjectLaserScan(orchard.Scan(i), ProjectionOptions());
      const SE2 truth = orchard.TruePose(i);
      if (i % 2 == 0) {
        mapped.grid.Insert(truth, scan);
        mapped.scans.push_back(scan);
        mapped.poses.push_back(truth);
      } else if (i % 8 == 1) {
        const double x = random.Uniform(-0.2, 0.2);
        const double y = random.Uniform(-0.2, 0.2);
        const SE2 error(x, y, random.Uniform(-0.1, 0.1));
        mapped.queries.push_back({scan.points, Sample(scan.points, matcher.max_search_points), truth, truth * error});
      }
    }
    mapped.cells = mapped.grid.OccupiedCells(static_cast<float>(LogOddsOf(TrackerOptions().min_occupancy)));
    mapped.target = MatchTarget(mapped.cells, mapped.grid.cell_size(), matcher.max_distance);
    return mapped;
  }

  /// Every n-th of `points`, so that there are no more than `max_points`.
  static std::vector<Eigen::Vector2f> Sample(const std::vector<Eigen::Vector2f>& points, int max_points) {
    const size_t most = static_cast<size_t>(max_points);
    const size_t stride = (points.size() + most - 1) / most;
    std::vector<Eigen::Vector2f> sample;
    for (size_t i = 0; i < points.size(); i += stride) sample.push_back(points[i]);
    return sample;
  }
};

/// The mapped orchard, built when first asked for.
inline const MappedOrchard& SharedMappedOrchard() {
  static const MappedOrchard* const mapped = new MappedOrchard(MappedOrchard::Build());
  return *mapped;
}

/// A run as the backend sees it: noisy relative poses between keyframes and submaps, without any scan.
struct MeasuredRun {
  /// [keyframes] from one submap to the next; each lives for two of these.
  static constexpr int kSubmapInterval = 100;

  std::vector<SE2> keyframes;                        ///< True poses.
  std::vector<SE2> submaps;                          ///< True poses: those of every hundredth keyframe.
  std::vector<std::vector<Constraint>> constraints;  ///< For each keyframe, those that come with it; motion first.

  static MeasuredRun Simulate(int num_keyframes) {
    const PlanarOrchard orchard = BenchmarkOrchard(num_keyframes);
    MeasuredRun run;
    Random random(2);
    for (int k = 0; k < num_keyframes; ++k) {
      const KeyframeId id{k};
      run.keyframes.push_back(orchard.TruePose(static_cast<size_t>(k)));
      const SE2& pose = run.keyframes.back();
      std::vector<Constraint> constraints;
      if (k > 0) {
        const SE2& last = run.keyframes[static_cast<size_t>(k) - 1];
        constraints.push_back(
            Measure(KeyframeId{k - 1}, last, id, pose, {0.03, 0.01}, Constraint::Kind::kMotion, &random));
        const int newest = (k - 1) / kSubmapInterval;
        for (int s = newest > 0 ? newest - 1 : 0; s <= newest; ++s) {
          constraints.push_back(Measure(SubmapId{s}, run.submaps[static_cast<size_t>(s)], id, pose, {0.01, 0.003},
                                        Constraint::Kind::kSubmap, &random));
        }
      }
      if (k % kSubmapInterval == 0) {
        const SubmapId begun{static_cast<int>(run.submaps.size())};
        run.submaps.push_back(pose);
        constraints.push_back({begun, id, SE2(), 1e8 * Eigen::Matrix3d::Identity(), Constraint::Kind::kSubmap});
      }
      run.constraints.push_back(constraints);
    }
    return run;
  }

  /// Standard deviations of a measurement.
  struct Noise {
    double translation;  ///< [m]
    double rotation;     ///< [rad]
  };

  /// A measurement of T_from_to with the given noise.
  static Constraint Measure(NodeId from, const SE2& T_map_from, NodeId to, const SE2& T_map_to, const Noise& noise,
                            Constraint::Kind kind, Random* random) {
    const double x = noise.translation * random->Gaussian();
    const double y = noise.translation * random->Gaussian();
    const SE2 error(x, y, noise.rotation * random->Gaussian());
    const double shift = 1.0 / (noise.translation * noise.translation);
    const double turn = 1.0 / (noise.rotation * noise.rotation);
    return {from, to, T_map_from.Inverse() * T_map_to * error, Eigen::Vector3d(shift, shift, turn).asDiagonal(), kind};
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BENCHMARK_SIMULATED_RUN_H_
