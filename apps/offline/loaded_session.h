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
  std::shared_ptr<ValueStore> store;  ///< Of the scans and submaps.
  SessionContents contents;           ///< `Completed`.
};

/// Reads the session at `path`; throws `UserError`.
/// @param store of its scans and submaps; null: one as its own options have it.
LoadedSession LoadSession(const std::string& path, std::shared_ptr<ValueStore> store = nullptr);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_OFFLINE_LOADED_SESSION_H_
