#ifndef ARBORSLAM_BACKEND_STORE_SESSION_FORMAT_H_
#define ARBORSLAM_BACKEND_STORE_SESSION_FORMAT_H_

#include <optional>
#include <string>

#include "backend/store/database.h"
#include "frontend/tracking/constraint.h"

namespace arborslam {

// A session is an SQLite file; its application id says so, its user version is that of the format. Poses are columns
// (x, y [m], theta [rad]); scans, submaps and states are `BinaryWriter`s' bytes, each a frame of `Compressor`.
//
//     session      key, value: see `kSession...`
//     recordings   the recordings that the session was made from, by name
//     scans        every scan that was read, in order: `ScanResult`, and `PosedScan` when it was not skipped
//     keyframes    `PlanarScan`, and whether it became part of the maps
//     poses        T_map_node of keyframes (kind 0) and submaps (kind 1)
//     constraints  measurements, with where they come from (`NameOf`)
//     submaps      `Submap`, finished ones
//     tilts        of the posed scans of a finished session
//     state        `Slam::SaveState` at the moment of the last transaction
//
// Poses, constraints and submaps have a `stage`: 0 as they were tracked, which a run goes on with, and, in a finished
// session, 1 as loops, optimisation and refinement left them. A session that was merged from several recordings has
// stage 1 only, and no state: nothing can be tracked behind its last scan.

/// The version that this program writes.
constexpr int kSessionFormat = 4;

enum class SessionStage { kTracked = 0, kFinished = 1 };

// Keys of table `session`.
constexpr char kSessionConfig[] = "config";           ///< YAML text.
constexpr char kSessionFinished[] = "is_finished";    ///< 0 or 1.
constexpr char kSessionStampShift[] = "stamp_shift";  ///< [s], of a finished session: stamps are later than tracked.

/// Makes an empty session of the present format in an empty database.
void CreateSessionTables(Database* database);

/// The format version of a session. Throws `UserError` when the file is none, or is of a newer format.
int SessionFormatOf(Database* database);

/// Brings a session of an older format to the present one, in one transaction; does nothing to one of the present
/// format. Throws `UserError`, and then the session is as it was.
void MigrateSession(Database* database);

/// "submap", "motion", "loop" or "gap".
std::string NameOf(Constraint::Kind kind);
/// The inverse; nothing for another text.
std::optional<Constraint::Kind> ConstraintKindOf(const std::string& name);

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_SESSION_FORMAT_H_
