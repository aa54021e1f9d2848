#ifndef ARBORSLAM_BACKEND_STORE_SESSION_CONTENTS_H_
#define ARBORSLAM_BACKEND_STORE_SESSION_CONTENTS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/posed_scan.h"
#include "backend/scan_result.h"
#include "core/map/submap.h"

namespace arborslam {

/// All that a session holds, as a value: what resuming, merging, localising and exporting start from.
struct SessionContents {
  /// A scan that was read, posed or not.
  struct ReadScan {
    uint64_t fingerprint = 0;  ///< Of its measurements (`FingerprintOf`); 0: not known.
    ScanResult result;         ///< As known when it came.
  };

  /// A run that was mapped in one piece.
  struct Recording {
    std::string name;      ///< For people.
    size_t num_read = 0;   ///< Its share of `read`.
    size_t num_posed = 0;  ///< Its share of `scans`.
  };

  std::vector<Recording> recordings;  ///< One, or those that were merged. In their order come scans and keyframes.
  std::string config;                 ///< Options in effect, as YAML that `ConfigSchema` reads.
  bool is_finished = false;           ///< True: loops are closed and the graph is optimised; else it is the window's.
  std::vector<ReadScan> read;         ///< In the order of the recordings.
  std::vector<PosedScan> scans;       ///< Those of `read` that were not skipped, in their order.
  std::vector<Keyframe> keyframes;    ///< Keyframe i has id i.
  std::vector<Submap> submaps;        ///< Ascending ids. Of an unfinished session the finished ones, see `Completed`.
  PoseGraph graph;                    ///< T_map_node of all keyframes and submaps, and all measurements.
  std::string state;                  ///< Of an unfinished session: what `Slam` goes on with.
};

/// True if a session, which has a keyframe, was made from sweeps in space; false: from planar scans.
inline bool IsSpatial(const SessionContents& session) {
  return !session.keyframes.front().scan.Get()->point_rays_are_free;
}

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_SESSION_CONTENTS_H_
