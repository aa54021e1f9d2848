#ifndef ARBORSLAM_APPS_SESSION_COMMANDS_H_
#define ARBORSLAM_APPS_SESSION_COMMANDS_H_

#include <string>

namespace arborslam {

// The subcommands of arborslam_session, one a file; each returns the program's exit code and throws `UserError`.

/// Prints what the session at `path` holds.
int SessionInfo(const std::string& path);

/// Writes trajectory.tum, graph.g2o, map.yaml, map.pgm and map.png of the session at `path` into `folder`, which is
/// made if it does not exist.
int SessionExport(const std::string& path, const std::string& folder);

/// Reads all of the session at `path` and prints one line: that it is whole, or what is wrong first.
int SessionVerify(const std::string& path);

/// Brings the session at `path` to the present format.
int SessionMigrate(const std::string& path);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_SESSION_COMMANDS_H_
