#ifndef ARBORSLAM_TESTS_BACKEND_SESSION_OF_RUN_H_
#define ARBORSLAM_TESTS_BACKEND_SESSION_OF_RUN_H_

#include <string>
#include <vector>

#include "backend/scan_result.h"
#include "backend/slam.h"
#include "backend/store/session_contents.h"
#include "core/geometry/angles.h"
#include "core/simulation/planar_lidar.h"
#include "core/simulation/planar_orchard.h"
#include "core/simulation/random.h"

namespace arborslam {

/// Maps scans with the default options, to the end, as a session.
template <class AnyScan>
SessionContents SessionOf(const std::vector<AnyScan>& scans, const std::string& name) {
  Slam slam(SlamOptions(), 1);
  SessionContents session;
  for (const AnyScan& scan : scans) session.read.push_back({session.read.size() + 1, slam.AddScan(scan)});
  const FinishResult finish = slam.Finish(false);
  session.is_finished = true;
  session.scans = slam.scans();
  session.keyframes = slam.keyframes();
  session.submaps = slam.submaps();
  session.graph = slam.graph();
  session.recordings = {{name, session.read.size(), session.scans.size()}};
  return session;
}

/// A walk through an orchard that is not the orchard's own, against which it may be turned.
struct OtherWalk {
  std::vector<LaserScan> scans;
  std::vector<SE2> truth;  // T_world_base of each scan.

  /// Along the scans `first` to `last` of the orchard's walk, backwards when last < first and then facing that way,
  /// `offset` [m] to the side, with noise of its own; stamped from `start` [s], one a second.
  OtherWalk(const PlanarOrchard& orchard, int first, int last, double offset, int seed, double start) {
    Random random(seed);
    const PlanarLidar lidar{PlanarLidarOptions()};
    const int step = last < first ? -1 : 1;
    for (int i = first; i != last + step; i += step) {
      const SE2 facing(0.0, 0.01 * random.Gaussian(), (step < 0 ? kPi : 0.0) + 0.02 * random.Gaussian());
      truth.push_back(orchard.TruePose(static_cast<size_t>(i)) * SE2(0.0, offset, 0.0) * facing);
      const double stamp = start + static_cast<double>(scans.size());
      scans.push_back(lidar.Measure(orchard.world(), truth.back(), stamp, Tilt(), &random));
    }
  }
};

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_BACKEND_SESSION_OF_RUN_H_
