#ifndef ARBORSLAM_APPS_SESSION_COMMANDS_H_
#define ARBORSLAM_APPS_SESSION_COMMANDS_H_

#include <string>
#include <vector>

namespace arborslam {

// The subcommands of arborslam_session, one a file; each returns the program's exit code and throws `UserError`.

/// Prints what the session at `path` holds.
int SessionInfo(const std::string& path);

/// Writes trajectory.tum (of a merged session trajectory_1.tum, ..., one for each recording), graph.g2o, map.yaml,
/// map.pgm and map.png of the session at `path` into `folder`, which is made if it does not exist.
int SessionExport(const std::string& path, const std::string& folder);

/// Merges the sessions at `paths`, at least two, into one and writes session.db, trajectory_1.tum, trajectory_2.tum,
/// ... (one for each recording, in the frame of the first session), graph.g2o, map.yaml, map.pgm and map.png into
/// `folder`, which is made if it does not exist. Nothing is written when they cannot be merged.
/// @param assignments options over the first session's own, as "section.key=value".
int SessionMerge(const std::vector<std::string>& paths, const std::string& folder,
                 const std::vector<std::string>& assignments);

/// Reads all of the session at `path` and prints one line: that it is whole, or what is wrong first.
int SessionVerify(const std::string& path);

/// Brings the session at `path` to the present format.
int SessionMigrate(const std::string& path);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_SESSION_COMMANDS_H_
