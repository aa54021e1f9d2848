#include "apps/offline/known_session.h"

#include <utility>
#include <variant>

#include "apps/offline/loaded_session.h"
#include "backend/merge/known_scans.h"
#include "backend/store/fingerprint.h"
#include "backend/store/session_reader.h"
#include "core/error.h"

namespace arborslam {
namespace {

void RequireNewOfItsKind(const SessionContents& map, const std::string& path, const std::string& input,
                         const Scan& first) {
  const bool is_spatial = std::holds_alternative<LidarSweep>(first);
  if (is_spatial != IsSpatial(map)) {
    throw UserError(input,
                    is_spatial ? "holds sweeps in space, but the session " + path + " was made from planar scans"
                               : "holds planar scans, but the session " + path + " was made from sweeps in space",
                    "give a recording of the same kind of lidar");
  }
  if (KnownScans(map).Hold(FingerprintOf(first))) {
    throw UserError(input, "begins with a scan that the session " + path + " holds already",
                    "give each recording once");
  }
}

}  // namespace

double StampOf(const Scan& scan) {
  const auto* const sweep = std::get_if<LidarSweep>(&scan);
  return sweep != nullptr ? sweep->Middle() : std::get<LaserScan>(scan).stamp;
}

bool IsSameScan(const Scan& scan, const SessionContents::ReadScan& read) {
  const bool is_known = read.fingerprint != 0;
  return StampOf(scan) == read.result.stamp && (!is_known || FingerprintOf(scan) == read.fingerprint);
}

KnownSession ReadKnownSession(const std::string& path, const std::string& input, const std::optional<Scan>& first,
                              const std::shared_ptr<ValueStore>& store) {
  KnownSession known;
  if (ReadSessionSummary(path).recordings.size() == 1) {
    known.tracked = ReadTracked(path, store);
    if (!first || known.tracked.read.empty() || IsSameScan(*first, known.tracked.read.front())) return known;
    known.tracked = SessionContents();
  }
  SessionContents map = LoadSession(path, store).contents;
  if (map.keyframes.empty()) {
    throw UserError(path, "was made from another recording, and holds no keyframes yet", "leave --session out");
  }
  if (first) RequireNewOfItsKind(map, path, input, *first);
  known.map = std::move(map);
  return known;
}

}  // namespace arborslam
