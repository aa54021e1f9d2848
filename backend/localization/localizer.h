#ifndef ARBORSLAM_BACKEND_LOCALIZATION_LOCALIZER_H_
#define ARBORSLAM_BACKEND_LOCALIZATION_LOCALIZER_H_

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/graph/pose_graph.h"
#include "backend/keyframe.h"
#include "backend/loop/place_recognizer.h"
#include "backend/loop/submap_path.h"
#include "backend/loop/submap_targets.h"
#include "backend/slam.h"
#include "backend/slam_options.h"
#include "core/io/value_store.h"
#include "core/map/submap.h"

namespace arborslam {

struct LocalizerOptions {
  double search_translation = 0.5;  ///< [m], half width of the search around the prediction.
  double search_rotation = 0.15;    ///< [rad], the same in heading.
  double max_score = 0.10;          ///< [m], a scan whose MHD is above this does not measure the pose.
  double min_overlap = 0.5;         ///< Share of the scan's points that must meet the map.
  int max_misses = 8;               ///< The robot is lost when so many scans in a row are not found in the map.
  int vote_keyframes = 10;          ///< A first pose is sought among the answers of the last so many keyframes.
  int min_votes = 3;                ///< So many of them must agree, and more than twice as many as contradict.
  double vote_translation = 0.5;    ///< [m], answers agree when they place the robot no farther apart than this,
  double vote_rotation = 0.1;       ///< [rad], and turn it no farther apart than this.
  double jump_translation = 0.4;    ///< [m], a pose that leaves the prediction by more than this is reported as a jump.

  std::string Validate() const;

  template <class Visitor>
  void VisitFields(Visitor&& visit) {
    visit("search_translation", search_translation);
    visit("search_rotation", search_rotation);
    visit("max_score", max_score);
    visit("min_overlap", min_overlap);
    visit("max_misses", max_misses);
    visit("vote_keyframes", vote_keyframes);
    visit("min_votes", min_votes);
    visit("vote_translation", vote_translation);
    visit("vote_rotation", vote_rotation);
    visit("jump_translation", jump_translation);
  }
};

/// What is known of the robot's place in the map.
enum class LocalizationState {
  kNotYetLocated,  ///< No place was found so far.
  kLocated,
  kLost,  ///< It was located, and is no more.
};

/// "not yet located", "located", "lost".
const char* ToString(LocalizationState state);

/// One scan's result.
struct LocalizationResult {
  ScanResult odometry;  ///< How the scan fits those before it.
  LocalizationState state = LocalizationState::kNotYetLocated;
  SE2 T_map_base;            ///< In the map's frame; only when located.
  bool is_measured = false;  ///< The scan itself was found in the map; else its pose is the odometry's.
  bool is_fix = false;       ///< With this scan the robot was located, for the first time or again.
  MatchResult match;         ///< To the map; of scans that were matched to it.
  std::string reason;        ///< Why the scan was not found in the map; empty if it was.
  double jump = 0.0;         ///< [m] from the prediction, where that is more than `jump_translation`; else 0.
};

/// Tells where a robot drives in a map that was made before and is never changed. The motion between scans is that of
/// `Slam`'s odometry, the place in the map is measured by matching each scan to the stored submap nearest to the
/// prediction. Without a place, or lost, scans are asked where they were taken (`PlaceRecognizer`); the robot is
/// located only when several scans of different places, carried along by the odometry, agree: a wrong place is
/// worse than a late one. For one thread; deterministic.
class Localizer {
 public:
  /// @param options      of the run that made the map, so that scans are reduced in the same way.
  /// @param graph, keyframes, submaps the map, keyframe i with id i; must outlive this object.
  /// @param store        takes care of the odometry's scans and submaps; null: they are kept in memory.
  /// @param initial_pose T_map_base of the first scan, to about `PlaceOptions::search_translation` and
  ///                     `search_rotation`, if known. It is tried first; a wrong one is found out and given up.
  Localizer(const SlamOptions& options, const LocalizerOptions& localizer, const PoseGraph& graph,
            const std::vector<Keyframe>& keyframes, const std::vector<Submap>& submaps,
            const std::optional<SE2>& initial_pose, std::shared_ptr<ValueStore> store = nullptr);

  LocalizationResult AddScan(const LaserScan& scan) { return Add(scan); }
  /// The same for a sweep in space. A run takes scans of one kind only, that of the map.
  LocalizationResult AddScan(const LidarSweep& sweep) { return Add(sweep); }

 private:
  template <class AnyScan>
  LocalizationResult Add(const AnyScan& scan);
  // Scans of one place would all give the same answer: only those that lie apart are asked where they were taken.
  bool HasMovedSinceAsked(const SE2& T_odom_base) const;
  // Measures the place of a scan with these points near the prediction, or finds that it does not tell.
  void TrackInMap(const std::vector<Eigen::Vector2f>& points, LocalizationResult* result);
  // Asks where a keyframe with these points was taken, and whether enough keyframes agree by now.
  void SearchInMap(const std::vector<Eigen::Vector2f>& points, LocalizationResult* result);
  // The match of a scan in the map, near `T_map_base`: its pose becomes that in the map.
  MatchResult MatchInMap(const std::vector<Eigen::Vector2f>& points, const SE2& T_map_base, double translation,
                         double rotation);
  // Submaps around a pose, the one with the nearest keyframe first.
  std::vector<size_t> SubmapsAround(const SE2& T_map_base) const;
  bool IsFound(const MatchResult& match) const;
  // Begins a new odometry; what follows hangs on the pose of the next scan.
  void RestartOdometry();

  SlamOptions slam_options_;
  LocalizerOptions options_;
  const PoseGraph& graph_;
  const std::vector<Keyframe>& keyframes_;
  const std::vector<Submap>& submaps_;
  Matcher matcher_;
  std::vector<SubmapPath> paths_;  // Of `submaps_`.
  PlaceRecognizer recognizer_;
  SubmapTargets targets_;
  std::shared_ptr<ValueStore> store_;
  std::unique_ptr<Slam> odometry_;
  double vote_translation_step_;  // [m] and [rad], how far apart scans are asked where they were taken.
  double vote_rotation_step_;
  std::optional<SE2> asked_at_;  // T_odom_base of the last one.
  LocalizationState state_ = LocalizationState::kNotYetLocated;
  SE2 T_map_odom_;
  std::optional<SE2> initial_pose_;       // Until the first scan.
  std::deque<std::optional<SE2>> votes_;  // T_map_odom as the last keyframes had it, nothing where they did not tell.
  int num_misses_ = 0;                    // Scans in a row that were not found in the map.
  int num_odometry_misses_ = 0;           // Scans in a row that the odometry rejected.
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_LOCALIZATION_LOCALIZER_H_
