#include "backend/store/session_format.h"

#include <glog/logging.h>

#include <array>

#include "core/error.h"

namespace arborslam {
namespace {

// "ArbS".
constexpr int64_t kApplicationId = 0x41726253;

// What format 1 was. Every later one is this and the steps below, so that they cannot differ.
constexpr char kFirstFormat[] = R"(
CREATE TABLE session (key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE scans (id INTEGER PRIMARY KEY, stamp REAL NOT NULL, status INTEGER NOT NULL, data BLOB NOT NULL);
CREATE TABLE keyframes (id INTEGER PRIMARY KEY, is_inserted INTEGER NOT NULL, scan BLOB NOT NULL);
CREATE TABLE poses (stage INTEGER NOT NULL, kind INTEGER NOT NULL, id INTEGER NOT NULL,
                    x REAL NOT NULL, y REAL NOT NULL, theta REAL NOT NULL, PRIMARY KEY (stage, kind, id)) WITHOUT ROWID;
CREATE TABLE constraints (stage INTEGER NOT NULL, id INTEGER NOT NULL, provenance TEXT NOT NULL,
                          from_kind INTEGER NOT NULL, from_id INTEGER NOT NULL,
                          to_kind INTEGER NOT NULL, to_id INTEGER NOT NULL,
                          x REAL NOT NULL, y REAL NOT NULL, theta REAL NOT NULL,
                          i_xx REAL NOT NULL, i_xy REAL NOT NULL, i_xt REAL NOT NULL,
                          i_yx REAL NOT NULL, i_yy REAL NOT NULL, i_yt REAL NOT NULL,
                          i_tx REAL NOT NULL, i_ty REAL NOT NULL, i_tt REAL NOT NULL,
                          PRIMARY KEY (stage, id)) WITHOUT ROWID;
CREATE TABLE submaps (stage INTEGER NOT NULL, id INTEGER NOT NULL, data BLOB NOT NULL, PRIMARY KEY (stage, id));
CREATE TABLE tilts (scan INTEGER PRIMARY KEY, roll REAL NOT NULL, pitch REAL NOT NULL, z REAL NOT NULL);
CREATE TABLE state (id INTEGER PRIMARY KEY, data BLOB NOT NULL);
)";

// Step i leads from format i + 1 to the next.
constexpr std::array<const char*, kSessionFormat - 1> kSteps = {
    // By which a run that goes on knows its recording; of earlier scans it is not known.
    "ALTER TABLE scans ADD COLUMN fingerprint INTEGER NOT NULL DEFAULT 0;",
    // Until here a session was of one recording.
    "ALTER TABLE scans ADD COLUMN recording INTEGER NOT NULL DEFAULT 0;"
    "CREATE TABLE recordings (id INTEGER PRIMARY KEY, name TEXT NOT NULL);"
    "INSERT INTO recordings SELECT 0, value FROM session WHERE key = 'input';"
    "DELETE FROM session WHERE key = 'input';",
    // Until here no constraint was a gap; the tables are the same.
    "",
};

void SetFormat(Database* database, int format) { database->Execute("PRAGMA user_version = " + std::to_string(format)); }

void TakeSteps(Database* database, int format) {
  for (; format < kSessionFormat; ++format) database->Execute(kSteps[static_cast<size_t>(format - 1)]);
  SetFormat(database, format);
}

}  // namespace

void CreateSessionTables(Database* database) {
  database->Execute("BEGIN");
  database->Execute("PRAGMA application_id = " + std::to_string(kApplicationId));
  database->Execute(kFirstFormat);
  TakeSteps(database, 1);
  database->Execute("COMMIT");
}

int SessionFormatOf(Database* database) {
  if (database->Integer("PRAGMA application_id") != kApplicationId) {
    throw UserError(database->path(), "is an SQLite database but not a session",
                    "give a session.db that arborslam_offline wrote");
  }
  const int64_t format = database->Integer("PRAGMA user_version").value_or(0);
  if (format > kSessionFormat) {
    throw UserError(database->path(),
                    "is of session format " + std::to_string(format) + ", newer than " +
                        std::to_string(kSessionFormat) + " that this program knows",
                    "use the release of Arbor SLAM that wrote it, or a later one");
  }
  if (format < 1) {
    throw UserError(database->path(), "is damaged (session format " + std::to_string(format) + ")",
                    "use a copy, or map the recording again");
  }
  return static_cast<int>(format);
}

void MigrateSession(Database* database) {
  const int format = SessionFormatOf(database);
  if (format == kSessionFormat) return;
  database->Execute("BEGIN IMMEDIATE");
  try {
    TakeSteps(database, format);
    database->Execute("COMMIT");
  } catch (const UserError&) {
    database->Execute("ROLLBACK");
    throw;
  }
}

std::string NameOf(Constraint::Kind kind) {
  switch (kind) {
    case Constraint::Kind::kSubmap:
      return "submap";
    case Constraint::Kind::kMotion:
      return "motion";
    case Constraint::Kind::kLoop:
      return "loop";
    case Constraint::Kind::kGap:
      return "gap";
  }
  LOG(FATAL) << "a kind of constraint without a name";
}

std::optional<Constraint::Kind> ConstraintKindOf(const std::string& name) {
  for (const auto kind :
       {Constraint::Kind::kSubmap, Constraint::Kind::kMotion, Constraint::Kind::kLoop, Constraint::Kind::kGap}) {
    if (NameOf(kind) == name) return kind;
  }
  return std::nullopt;
}

}  // namespace arborslam
