#include "backend/store/session_writer.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/io/binary_archive.h"

namespace arborslam {
namespace {

// What SQLite keeps beside a database.
constexpr std::array<const char*, 3> kSideFiles = {"-wal", "-shm", "-journal"};

template <class... Values>
std::string Packed(Compressor* compressor, const Values&... values) {
  BinaryWriter bytes;
  bytes(values...);
  return compressor->Compress(bytes.bytes());
}

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

// Fills a new database and puts it in place of the file at `path`. Under its name it is whole from the start, and no
// unfinished transactions of the file before are taken for its own.
template <class Fill>
void MakeDatabase(const std::string& path, const Fill& fill) {
  const std::string temporary = path + ".new";
  for (const char* ending : kSideFiles) Remove(temporary + ending);
  Remove(temporary);
  try {
    Database database(temporary, Database::Mode::kCreate);
    fill(&database);
  } catch (const UserError&) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw;
  }
  for (const char* ending : kSideFiles) Remove(path + ending);
  std::error_code error;
  std::filesystem::rename(temporary, path, error);
  if (!error) return;
  Remove(temporary);
  throw UserError(path, "cannot be created (" + error.message() + ")", "choose another --output");
}

int KindOf(NodeId id) { return id.kind == NodeId::Kind::kKeyframe ? 0 : 1; }

}  // namespace

void CopySession(const std::string& source, const std::string& target) {
  Database database(source, Database::Mode::kRead);
  SessionFormatOf(&database);
  MakeDatabase(target, [&database](Database* copy) { copy->CopyFrom(database); });
}

struct SessionWriter::Statements {
  explicit Statements(Database* database)
      : scan(database, "INSERT INTO scans (id, stamp, status, data, fingerprint) VALUES (?, ?, ?, ?, ?)"),
        keyframe(database, "INSERT INTO keyframes VALUES (?, ?, ?)"),
        pose(database, "INSERT OR REPLACE INTO poses VALUES (?, ?, ?, ?, ?, ?)"),
        constraint(database,
                   "INSERT INTO constraints VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
        submap(database, "INSERT INTO submaps VALUES (?, ?, ?)"),
        state(database, "INSERT OR REPLACE INTO state VALUES (0, ?)") {}

  Database::Statement scan;
  Database::Statement keyframe;
  Database::Statement pose;
  Database::Statement constraint;
  Database::Statement submap;
  Database::Statement state;
};

std::unique_ptr<SessionWriter> SessionWriter::Create(const std::string& path, const std::string& config,
                                                     const std::string& input) {
  MakeDatabase(path, [&](Database* database) {
    CreateSessionTables(database);
    SetValue(database, kSessionConfig, config);
    SetValue(database, kSessionInput, input);
    SetFinished(database, false);
  });
  return std::unique_ptr<SessionWriter>(new SessionWriter(path, Written()));
}

std::unique_ptr<SessionWriter> SessionWriter::Continue(const std::string& path, const SessionContents& contents) {
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
  return std::unique_ptr<SessionWriter>(new SessionWriter(path, std::move(written)));
}

SessionWriter::SessionWriter(const std::string& path, Written written)
    : path_(path), database_(std::in_place, path, Database::Mode::kWrite), written_(std::move(written)) {
  // One writer at a time, and none of the memory that readers would share with it.
  database_->Execute("PRAGMA locking_mode = EXCLUSIVE");
  database_->Execute("PRAGMA journal_mode = WAL");
  // A killed program loses nothing that was committed; a power cut may lose the last transactions, never the file.
  database_->Execute("PRAGMA synchronous = NORMAL");
  MigrateSession(&*database_);
  statements_ = std::make_unique<Statements>(&*database_);
}

SessionWriter::~SessionWriter() = default;

void SessionWriter::Begin() {
  if (in_transaction_) return;
  database_->Execute("BEGIN IMMEDIATE");
  in_transaction_ = true;
}

void SessionWriter::Add(uint64_t fingerprint, const ScanResult& result, const Slam& slam) {
  Begin();
  const bool is_posed = slam.scans().size() > written_.posed;
  CHECK_EQ(is_posed, result.status != ScanStatus::kSkipped);
  statements_->scan.Bind(static_cast<int64_t>(written_.read))
      .Bind(result.stamp)
      .Bind(static_cast<int64_t>(result.status))
      .BindBytes(is_posed ? Packed(&compressor_, result, slam.scans().back()) : Packed(&compressor_, result))
      .Bind(static_cast<int64_t>(fingerprint))
      .Run();
  ++written_.read;
  written_.posed = slam.scans().size();
  const std::chrono::duration<double> since_commit = std::chrono::steady_clock::now() - last_commit_;
  if (since_commit.count() >= kInterval) Commit(slam);
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
    const Keyframe& keyframe = slam.keyframes()[written_.keyframes];
    statements_->keyframe.Bind(static_cast<int64_t>(keyframe.id.value))
        .Bind(static_cast<int64_t>(keyframe.is_inserted))
        .BindBytes(Packed(&compressor_, keyframe.scan))
        .Run();
  }
  for (; written_.constraints < slam.graph().constraints().size(); ++written_.constraints) {
    WriteConstraint(SessionStage::kTracked, written_.constraints, slam.graph().constraints()[written_.constraints]);
  }
  for (; written_.submaps < slam.submaps().size(); ++written_.submaps) {
    WriteSubmap(SessionStage::kTracked, slam.submaps()[written_.submaps]);
  }
  statements_->state.BindBytes(Packed(&compressor_, slam.SaveState())).Run();
  database_->Execute("COMMIT");
  in_transaction_ = false;
  last_commit_ = std::chrono::steady_clock::now();
}

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
  for (const NodeId id : moved) WritePose(SessionStage::kTracked, id, slam.graph().Pose(id));
}

void SessionWriter::WritePose(SessionStage stage, NodeId id, const SE2& pose) {
  statements_->pose.Bind(static_cast<int64_t>(stage))
      .Bind(static_cast<int64_t>(KindOf(id)))
      .Bind(static_cast<int64_t>(id.value))
      .Bind(pose.x())
      .Bind(pose.y())
      .Bind(pose.theta())
      .Run();
}

void SessionWriter::WriteConstraint(SessionStage stage, size_t id, const Constraint& constraint) {
  Database::Statement& statement = statements_->constraint;
  statement.Bind(static_cast<int64_t>(stage))
      .Bind(static_cast<int64_t>(id))
      .BindText(NameOf(constraint.kind))
      .Bind(static_cast<int64_t>(KindOf(constraint.from)))
      .Bind(static_cast<int64_t>(constraint.from.value))
      .Bind(static_cast<int64_t>(KindOf(constraint.to)))
      .Bind(static_cast<int64_t>(constraint.to.value))
      .Bind(constraint.T_from_to.x())
      .Bind(constraint.T_from_to.y())
      .Bind(constraint.T_from_to.theta());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) statement.Bind(constraint.information(row, column));
  }
  statement.Run();
}

void SessionWriter::WriteSubmap(SessionStage stage, const Submap& submap) {
  statements_->submap.Bind(static_cast<int64_t>(stage))
      .Bind(static_cast<int64_t>(submap.id.value))
      .BindBytes(Packed(&compressor_, submap))
      .Run();
}

void SessionWriter::Discard() {
  statements_.reset();
  database_.reset();
  for (const char* ending : kSideFiles) Remove(path_ + ending);
  Remove(path_);
}

void SessionWriter::Finish(const Slam& slam, double stamp_shift) {
  Begin();
  for (const auto& [id, pose] : slam.graph().poses()) WritePose(SessionStage::kFinished, id, pose);
  for (size_t i = 0; i < slam.graph().constraints().size(); ++i) {
    WriteConstraint(SessionStage::kFinished, i, slam.graph().constraints()[i]);
  }
  for (const Submap& submap : slam.submaps()) WriteSubmap(SessionStage::kFinished, submap);
  {
    Database::Statement tilt(&*database_, "INSERT INTO tilts VALUES (?, ?, ?, ?)");
    for (size_t i = 0; i < slam.scans().size(); ++i) {
      const Tilt3& value = slam.scans()[i].tilt;
      tilt.Bind(static_cast<int64_t>(i)).Bind(value.roll).Bind(value.pitch).Bind(value.z).Run();
    }
  }
  Database::Statement(&*database_, "INSERT OR REPLACE INTO session VALUES (?, ?)")
      .BindText(kSessionStampShift)
      .Bind(stamp_shift)
      .Run();
  SetFinished(&*database_, true);
  database_->Execute("COMMIT");
  in_transaction_ = false;
  statements_.reset();
  database_->Execute("PRAGMA journal_mode = DELETE");
}

}  // namespace arborslam
