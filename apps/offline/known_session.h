#ifndef ARBORSLAM_APPS_OFFLINE_KNOWN_SESSION_H_
#define ARBORSLAM_APPS_OFFLINE_KNOWN_SESSION_H_

#include <memory>
#include <optional>
#include <string>

#include "backend/store/session_contents.h"
#include "core/io/scan_source.h"

namespace arborslam {

/// A session as a run on a recording goes on with it.
struct KnownSession {
  SessionContents tracked;             ///< The recording's own run, as far as it came; empty when there is a `map`.
  std::optional<SessionContents> map;  ///< `Completed`, not empty, of other recordings: this one is new in it.
};

/// Reads the session at `path` for a run on the recording `input`, whose first scan is `first` (nothing if it holds
/// none). That is the session's own recording if it begins with the session's first scan, and new otherwise. Throws
/// `UserError`, also for a new recording that is of another kind of lidar or begins with a scan that the session holds.
/// @param store of the session's scans and submaps; null: they are kept in memory.
KnownSession ReadKnownSession(const std::string& path, const std::string& input, const std::optional<Scan>& first,
                              const std::shared_ptr<ValueStore>& store);

/// [s], as the stamps of results have it: of a sweep its middle.
double StampOf(const Scan& scan);

/// True if `scan` is the one that a session read, as far as it knows.
bool IsSameScan(const Scan& scan, const SessionContents::ReadScan& read);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_KNOWN_SESSION_H_
