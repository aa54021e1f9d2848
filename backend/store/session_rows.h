#ifndef ARBORSLAM_BACKEND_STORE_SESSION_ROWS_H_
#define ARBORSLAM_BACKEND_STORE_SESSION_ROWS_H_

#include <cstddef>
#include <string>

#include "backend/keyframe.h"
#include "backend/posed_scan.h"
#include "backend/store/compression.h"
#include "backend/store/database.h"
#include "backend/store/session_contents.h"
#include "backend/store/session_format.h"
#include "core/geometry/se2.h"
#include "core/geometry/tilt.h"
#include "core/map/ids.h"
#include "core/map/submap.h"
#include "frontend/tracking/constraint.h"

namespace arborslam {

/// Writes the rows of a session's tables, see session_format.h; transactions are the caller's. Throws `UserError`. For
/// one thread.
class SessionRows {
 public:
  /// `database` is a session of the present format and must outlive this object.
  explicit SessionRows(Database* database);

  void AddRecording(size_t id, const std::string& name);
  /// @param posed the scan's pose; nullptr when it was skipped.
  void AddScan(size_t id, size_t recording, const SessionContents::ReadScan& scan, const PosedScan* posed);
  void AddKeyframe(const Keyframe& keyframe);
  void SetPose(SessionStage stage, NodeId id, const SE2& T_map_node);
  void AddConstraint(SessionStage stage, size_t id, const Constraint& constraint);
  void AddSubmap(SessionStage stage, const Submap& submap);
  /// @param scan among those with a pose.
  void AddTilt(size_t scan, const Tilt3& tilt);
  void SetState(const std::string& state);

 private:
  template <class... Values>
  std::string Packed(const Values&... values);

  Compressor compressor_;
  Database::Statement recording_;
  Database::Statement scan_;
  Database::Statement keyframe_;
  Database::Statement pose_;
  Database::Statement constraint_;
  Database::Statement submap_;
  Database::Statement tilt_;
  Database::Statement state_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_SESSION_ROWS_H_
