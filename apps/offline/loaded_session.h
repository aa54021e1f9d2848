#ifndef ARBORSLAM_APPS_OFFLINE_LOADED_SESSION_H_
#define ARBORSLAM_APPS_OFFLINE_LOADED_SESSION_H_

#include <memory>
#include <string>

#include "apps/offline/offline_options.h"
#include "backend/store/session_contents.h"

namespace arborslam {

/// The options that a session was made with, from its YAML. Throws `UserError`, naming `path`.
OfflineOptions SessionOptions(const std::string& config, const std::string& path);

/// A session with its options.
struct LoadedSession {
  OfflineOptions options;
  SessionContents contents;  ///< `Completed`.
};

/// Reads the session at `path`, with a store of its scans and submaps as its own options have it; throws `UserError`.
LoadedSession LoadSession(const std::string& path);

/// The same with another store; null: scans and submaps are kept in memory.
LoadedSession LoadSession(const std::string& path, const std::shared_ptr<ValueStore>& store);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_LOADED_SESSION_H_
