#include "backend/store/session_rows.h"

#include "core/io/binary_archive.h"

namespace arborslam {
namespace {

int64_t KindOf(NodeId id) { return id.kind == NodeId::Kind::kKeyframe ? 0 : 1; }

}  // namespace

SessionRows::SessionRows(Database* database)
    : recording_(database, "INSERT INTO recordings VALUES (?, ?)"),
      scan_(database, "INSERT INTO scans (id, stamp, status, data, fingerprint, recording) VALUES (?, ?, ?, ?, ?, ?)"),
      keyframe_(database, "INSERT INTO keyframes VALUES (?, ?, ?)"),
      pose_(database, "INSERT OR REPLACE INTO poses VALUES (?, ?, ?, ?, ?, ?)"),
      constraint_(database, "INSERT INTO constraints VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      submap_(database, "INSERT INTO submaps VALUES (?, ?, ?)"),
      tilt_(database, "INSERT INTO tilts VALUES (?, ?, ?, ?)"),
      state_(database, "INSERT OR REPLACE INTO state VALUES (0, ?)") {}

template <class... Values>
std::string SessionRows::Packed(const Values&... values) {
  BinaryWriter bytes;
  bytes(values...);
  return compressor_.Compress(bytes.bytes());
}

void SessionRows::AddRecording(size_t id, const std::string& name) {
  recording_.Bind(static_cast<int64_t>(id)).BindText(name).Run();
}

void SessionRows::AddScan(size_t id, size_t recording, const SessionContents::ReadScan& scan, const PosedScan* posed) {
  scan_.Bind(static_cast<int64_t>(id))
      .Bind(scan.result.stamp)
      .Bind(static_cast<int64_t>(scan.result.status))
      .BindBytes(posed == nullptr ? Packed(scan.result) : Packed(scan.result, *posed))
      .Bind(static_cast<int64_t>(scan.fingerprint))
      .Bind(static_cast<int64_t>(recording))
      .Run();
}

void SessionRows::AddKeyframe(const Keyframe& keyframe) {
  keyframe_.Bind(static_cast<int64_t>(keyframe.id.value))
      .Bind(static_cast<int64_t>(keyframe.is_inserted))
      .BindBytes(Packed(keyframe.scan))
      .Run();
}

void SessionRows::SetPose(SessionStage stage, NodeId id, const SE2& T_map_node) {
  pose_.Bind(static_cast<int64_t>(stage))
      .Bind(KindOf(id))
      .Bind(static_cast<int64_t>(id.value))
      .Bind(T_map_node.x())
      .Bind(T_map_node.y())
      .Bind(T_map_node.theta())
      .Run();
}

void SessionRows::AddConstraint(SessionStage stage, size_t id, const Constraint& constraint) {
  constraint_.Bind(static_cast<int64_t>(stage))
      .Bind(static_cast<int64_t>(id))
      .BindText(NameOf(constraint.kind))
      .Bind(KindOf(constraint.from))
      .Bind(static_cast<int64_t>(constraint.from.value))
      .Bind(KindOf(constraint.to))
      .Bind(static_cast<int64_t>(constraint.to.value))
      .Bind(constraint.T_from_to.x())
      .Bind(constraint.T_from_to.y())
      .Bind(constraint.T_from_to.theta());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) constraint_.Bind(constraint.information(row, column));
  }
  constraint_.Run();
}

void SessionRows::AddSubmap(SessionStage stage, const Submap& submap) {
  submap_.Bind(static_cast<int64_t>(stage)).Bind(static_cast<int64_t>(submap.id.value)).BindBytes(Packed(submap)).Run();
}

void SessionRows::AddTilt(size_t scan, const Tilt3& tilt) {
  tilt_.Bind(static_cast<int64_t>(scan)).Bind(tilt.roll).Bind(tilt.pitch).Bind(tilt.z).Run();
}

void SessionRows::SetState(const std::string& state) { state_.BindBytes(Packed(state)).Run(); }

}  // namespace arborslam
