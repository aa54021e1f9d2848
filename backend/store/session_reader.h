#ifndef ARBORSLAM_BACKEND_STORE_SESSION_READER_H_
#define ARBORSLAM_BACKEND_STORE_SESSION_READER_H_

#include <memory>
#include <string>
#include <vector>

#include "backend/slam_options.h"
#include "backend/store/session_contents.h"
#include "core/io/value_store.h"

namespace arborslam {

/// What can be told of a session without reading it all.
struct SessionSummary {
  int format = 0;                       ///< Version.
  std::vector<std::string> recordings;  ///< Their names, at least one.
  bool is_finished = false;
  std::string config;  ///< YAML.
};

/// Reads the session at `path` as its run left it: when it was finished the optimised graph, maps and tilts, else what
/// the window and the submaps had come to with the last transaction. Sessions of older formats are read alike; the file
/// stays as it is, but for what a killed program had left beside it. All errors are `UserError`s: a file that is no
/// session, a newer format, and whatever does not go together in it.
/// @param store takes care of scans and submaps; null: they are kept in memory.
SessionContents ReadSession(const std::string& path, const std::shared_ptr<ValueStore>& store = nullptr);

/// The same as it was tracked, for a run that goes on with it, though it be finished: `is_finished` is false. A session
/// that was merged from several recordings is an error, too.
SessionContents ReadTracked(const std::string& path, const std::shared_ptr<ValueStore>& store = nullptr);

/// Throws `UserError` as `ReadSession` does, but looks at little.
SessionSummary ReadSessionSummary(const std::string& path);

/// A session as it would be had the recording ended there, without loops closed: growing submaps are finished, heights
/// and tilts smoothed. `options` must be the session's. Sessions that are finished are returned as they are. Throws
/// `UserError`, naming `place`, when the parts of `contents` do not go together.
SessionContents Completed(SessionContents contents, const SlamOptions& options, const std::string& place);

/// What is wrong with the file as a database, from SQLite's own thorough check; empty if nothing is.
std::vector<std::string> DatabaseProblems(const std::string& path);

/// Brings the session at `path` to the present format; returns that which it had. Throws `UserError`.
int MigrateSessionFile(const std::string& path);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_SESSION_READER_H_
