#include "backend/store/session_writer.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "backend/store/session_format.h"
#include "core/error.h"

namespace arborslam {
namespace {

// What SQLite keeps beside a database.
constexpr std::array<const char*, 3> kSideFiles = {"-wal", "-shm", "-journal"};

void SetValue(Database* database, const char* key, const std::string& text) {
  Database::Statement(database, "INSERT OR REPLACE INTO session VALUES (?, ?)").BindText(key).BindText(text).Run();
}

void SetFinished(Database* database, bool is_finished) {
  Database::Statement(database, "INSERT OR REPLACE INTO session VALUES (?, ?)")
      .BindText(kSessionFinished)
      .Bind(static_cast<int64_t>(is_finished))
      .Run();
}

void DeleteFinished(Database* database) {
  database->Execute(
      "DELETE FROM poses WHERE stage = 1; DELETE FROM constraints WHERE stage = 1; DELETE FROM submaps WHERE stage = 1;"
      "DELETE FROM tilts");
}

void Remove(const std::string& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) throw UserError(path, "cannot be replaced (" + error.message() + ")", "remove it");
}

void RemoveDatabase(const std::string& path) {
  for (const char* ending : kSideFiles) Remove(path + ending);
  Remove(path);
}

void TryToRemoveDatabase(const std::string& path) {
  std::error_code ignored;
  for (const char* ending : kSideFiles) std::filesystem::remove(path + ending, ignored);
  std::filesystem::remove(path, ignored);
}

// What a session is called until it is put in place of the file at `path`.
std::string NewName(const std::string& path) { return path + ".new"; }

// Fills a new database at `path`.
template <class Fill>
void FillNew(const std::string& path, const Fill& fill) {
  RemoveDatabase(path);
  try {
    Database database(path, Database::Mode::kCreate);
    fill(&database);
  } catch (const UserError&) {
    TryToRemoveDatabase(path);
    throw;
  }
}

// Puts a database that is closed in place of the file at `path`. No unfinished transactions of the file before are
// taken for its own.
void PutInPlace(const std::string& source, const std::string& path) {
  for (const char* ending : kSideFiles) Remove(path + ending);
  std::error_code error;
  std::filesystem::rename(source, path, error);
  if (error) throw UserError(path, "cannot be created (" + error.message() + ")", "choose another --output");
}

// What the end of a run came to; its scans are written already, with stamps that are earlier by `stamp_shift` [s].
void WriteFinished(const PoseGraph& graph, const std::vector<Submap>& submaps, const std::vector<PosedScan>& scans,
                   double stamp_shift, Database* database, SessionRows* rows) {
  for (const auto& [id, pose] : graph.poses()) rows->SetPose(SessionStage::kFinished, id, pose);
  for (size_t i = 0; i < graph.constraints().size(); ++i) {
    rows->AddConstraint(SessionStage::kFinished, i, graph.constraints()[i]);
  }
  for (const Submap& submap : submaps) rows->AddSubmap(SessionStage::kFinished, submap);
  for (size_t i = 0; i < scans.size(); ++i) rows->AddTilt(i, scans[i].tilt);
  Database::Statement(database, "INSERT OR REPLACE INTO session VALUES (?, ?)")
      .BindText(kSessionStampShift)
      .Bind(stamp_shift)
      .Run();
  SetFinished(database, true);
}

}  // namespace

void MoveSession(const std::string& source, const std::string& target) { PutInPlace(source, target); }

void WriteSession(const std::string& path, const SessionContents& contents) {
  const std::string temporary = NewName(path);
  FillNew(temporary, [&](Database* database) {
    CreateSessionTables(database);
    database->Execute("BEGIN");
    SetValue(database, kSessionConfig, contents.config);
    SessionRows rows(database);
    size_t read = 0;
    size_t posed = 0;
    for (size_t i = 0; i < contents.recordings.size(); ++i) {
      rows.AddRecording(i, contents.recordings[i].name);
      for (const size_t end = read + contents.recordings[i].num_read; read < end; ++read) {
        const bool is_posed = contents.read[read].result.status != ScanStatus::kSkipped;
        rows.AddScan(read, i, contents.read[read], is_posed ? &contents.scans[posed++] : nullptr);
      }
    }
    for (const Keyframe& keyframe : contents.keyframes) rows.AddKeyframe(keyframe);
    WriteFinished(contents.graph, contents.submaps, contents.scans, 0.0, database, &rows);
    database->Execute("COMMIT");
  });
  try {
    PutInPlace(temporary, path);
  } catch (const UserError&) {
    TryToRemoveDatabase(temporary);
    throw;
  }
}

std::unique_ptr<SessionWriter> SessionWriter::Create(const std::string& path, const std::string& config,
                                                     const std::string& input) {
  FillNew(NewName(path), [&](Database* database) {
    CreateSessionTables(database);
    SetValue(database, kSessionConfig, config);
    SetFinished(database, false);
    SessionRows(database).AddRecording(0, input);
  });
  return Opened(path, NewName(path), Written());
}

std::unique_ptr<SessionWriter> SessionWriter::Continue(const std::string& path, const SessionContents& contents) {
  return Opened(path, path, WrittenOf(contents));
}

std::unique_ptr<SessionWriter> SessionWriter::ContinueCopy(const std::string& source, const std::string& path,
                                                           const SessionContents& contents) {
  Database database(source, Database::Mode::kRead);
  SessionFormatOf(&database);
  FillNew(NewName(path), [&database](Database* copy) { copy->CopyFrom(database); });
  return Opened(path, NewName(path), WrittenOf(contents));
}

std::unique_ptr<SessionWriter> SessionWriter::Opened(const std::string& path, const std::string& file,
                                                     Written written) {
  std::unique_ptr<SessionWriter> session(new SessionWriter(path, file, std::move(written)));
  session->Open();
  return session;
}

SessionWriter::Written SessionWriter::WrittenOf(const SessionContents& contents) {
  Written written;
  written.may_have_end = true;
  written.read = contents.read.size();
  written.posed = contents.scans.size();
  written.keyframes = contents.keyframes.size();
  written.submaps = contents.submaps.size();
  written.constraints = contents.graph.constraints().size();
  written.submap_nodes = contents.graph.poses().size() - contents.keyframes.size();
  // Which of them the window still moves is not known here: the first transaction writes them all.
  for (const auto& [id, pose] : contents.graph.poses()) written.open.push_back(id);
  return written;
}

SessionWriter::SessionWriter(const std::string& path, const std::string& file, Written written)
    : path_(path), file_(file), is_own_(file != path), written_(std::move(written)) {}

SessionWriter::~SessionWriter() {
  if (IsInPlace()) return;
  Close();
  TryToRemoveDatabase(file_);
}

void SessionWriter::Open() {
  database_.emplace(file_, Database::Mode::kWrite);
  // One writer at a time, and none of the memory that readers would share with it.
  database_->Execute("PRAGMA locking_mode = EXCLUSIVE");
  // A file that is to be renamed holds all that was committed; one in its place may have its latest beside it.
  database_->Execute(std::string("PRAGMA journal_mode = ") + (IsInPlace() ? "WAL" : "DELETE"));
  // A killed program loses nothing that was committed; a power cut may lose the last transactions, never the file.
  database_->Execute("PRAGMA synchronous = NORMAL");
  MigrateSession(&*database_);
  rows_ = std::make_unique<SessionRows>(&*database_);
}

void SessionWriter::Close() {
  rows_.reset();
  database_.reset();
}

void SessionWriter::MoveIntoPlace() {
  Close();
  PutInPlace(file_, path_);
  file_ = path_;
  Open();
}

void SessionWriter::Begin() {
  if (in_transaction_) return;
  database_->Execute("BEGIN IMMEDIATE");
  in_transaction_ = true;
}

void SessionWriter::Add(uint64_t fingerprint, const ScanResult& result, const Slam& slam) {
  Begin();
  const bool is_posed = slam.scans().size() > written_.posed;
  CHECK_EQ(is_posed, result.status != ScanStatus::kSkipped);
  // A run that is written as it goes is of one recording.
  rows_->AddScan(written_.read, 0, {fingerprint, result}, is_posed ? &slam.scans().back() : nullptr);
  ++written_.read;
  written_.posed = slam.scans().size();
  const std::chrono::duration<double> since_commit = std::chrono::steady_clock::now() - last_commit_;
  if (since_commit.count() >= kInterval || IsWorthItsPlace(slam)) Commit(slam);
}

void SessionWriter::Commit(const Slam& slam) {
  Begin();
  if (written_.may_have_end) {
    DeleteFinished(&*database_);
    SetFinished(&*database_, false);
    written_.may_have_end = false;
  }
  WritePoses(slam);
  for (; written_.keyframes < slam.keyframes().size(); ++written_.keyframes) {
    rows_->AddKeyframe(slam.keyframes()[written_.keyframes]);
  }
  for (; written_.constraints < slam.graph().constraints().size(); ++written_.constraints) {
    rows_->AddConstraint(SessionStage::kTracked, written_.constraints,
                         slam.graph().constraints()[written_.constraints]);
  }
  for (; written_.submaps < slam.submaps().size(); ++written_.submaps) {
    rows_->AddSubmap(SessionStage::kTracked, slam.submaps()[written_.submaps]);
  }
  rows_->SetState(slam.SaveState());
  database_->Execute("COMMIT");
  in_transaction_ = false;
  last_commit_ = std::chrono::steady_clock::now();
  if (IsWorthItsPlace(slam)) MoveIntoPlace();
}

bool SessionWriter::IsWorthItsPlace(const Slam& slam) const { return !IsInPlace() && !slam.keyframes().empty(); }

void SessionWriter::WritePoses(const Slam& slam) {
  std::vector<NodeId> moved = std::move(written_.open);
  for (size_t i = written_.keyframes; i < slam.keyframes().size(); ++i) moved.push_back(slam.keyframes()[i].id);
  for (;; ++written_.submap_nodes) {
    const SubmapId id{static_cast<int>(written_.submap_nodes)};
    if (slam.graph().poses().count(id) == 0) break;
    moved.push_back(id);
  }
  written_.open.clear();
  for (const auto& [id, pose] : slam.window().poses()) written_.open.push_back(id);
  for (const NodeId id : moved) rows_->SetPose(SessionStage::kTracked, id, slam.graph().Pose(id));
}

void SessionWriter::Discard() {
  Close();
  if (is_own_) RemoveDatabase(file_);
}

void SessionWriter::Finish(const Slam& slam, double stamp_shift) {
  Begin();
  WriteFinished(slam.graph(), slam.submaps(), slam.scans(), stamp_shift, &*database_, rows_.get());
  database_->Execute("COMMIT");
  in_transaction_ = false;
  rows_.reset();
  database_->Execute("PRAGMA journal_mode = DELETE");
  Close();
}

}  // namespace arborslam
