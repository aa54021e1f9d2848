#include "backend/store/database.h"

#include <glog/logging.h>
#include <sqlite3.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/io/input_file.h"

namespace arborslam {
namespace {

constexpr int kBusyTimeoutMs = 2000;
constexpr char kUseCopy[] = "use a copy, or map the recording again";

// `path` as SQLite reads it, for a file that nobody changes.
std::string ImmutableUri(const std::string& path) {
  std::string uri = "file:";
  for (const char character : path) {
    if (character == '%' || character == '?' || character == '#') {
      constexpr char kDigits[] = "0123456789ABCDEF";
      uri += {'%', kDigits[character >> 4], kDigits[character & 15]};
    } else {
      uri += character;
    }
  }
  return uri + "?immutable=1";
}

// What SQLite wrote beside the file and has not yet put into it.
bool HasPendingChanges(const std::string& path) {
  for (const char* ending : {"-wal", "-journal"}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path + ending, error);
    if (!error && size > 0) return true;
  }
  return false;
}

}  // namespace

void Database::Closer::operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
void Database::Statement::Finalizer::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Database::Database(std::string path, Mode mode) : path_(std::move(path)) {
  if (mode == Mode::kRead || mode == Mode::kWrite) OpenInputFile(path_);
  switch (mode) {
    case Mode::kRead:
      OpenToRead();
      break;
    case Mode::kWrite:
      Check(Open(path_, SQLITE_OPEN_READWRITE));
      if (sqlite3_db_readonly(connection_.get(), "main") == 1) {
        throw UserError(path_, "may not be written", "change its permissions or use a copy");
      }
      break;
    case Mode::kCreate:
      Check(Open(path_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
      break;
    case Mode::kMemory:
      Check(Open(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
      break;
  }
}

int Database::Open(const std::string& name, int flags) {
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &connection, flags | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  connection_.reset(connection);
  if (code != SQLITE_OK) return code;
  sqlite3_extended_result_codes(connection, 1);
  sqlite3_busy_timeout(connection, kBusyTimeoutMs);
  // What others may have put into the file is data, not code.
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  return sqlite3_exec(connection, "PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;", nullptr, nullptr,
                      nullptr);
}

void Database::OpenToRead() {
  // A file that was being written when its program ended is first completed from what stands beside it, which needs
  // the right to write.
  const auto read = [this] {
    return sqlite3_exec(connection_.get(), "SELECT count(*) FROM sqlite_schema", nullptr, nullptr, nullptr);
  };
  int code = Open(path_, SQLITE_OPEN_READWRITE);
  if (code == SQLITE_OK) code = read();
  const int primary = code & 0xff;
  if (primary == SQLITE_CANTOPEN || primary == SQLITE_READONLY || primary == SQLITE_PERM) {
    if (HasPendingChanges(path_)) {
      throw UserError(path_,
                      "was not closed, and its folder may not be written to complete it from the files beside it",
                      "copy it with its -wal file to another folder");
    }
    code = Open(ImmutableUri(path_), SQLITE_OPEN_READONLY);
    if (code == SQLITE_OK) code = read();
  }
  Check(code);
}

void Database::Check(int code) const {
  if (code != SQLITE_OK && code != SQLITE_ROW && code != SQLITE_DONE) Fail(code);
}

void Database::Fail(int code) const {
  const int system_error = connection_ ? sqlite3_system_errno(connection_.get()) : 0;
  const std::string reason = system_error != 0 ? std::strerror(system_error) : sqlite3_errstr(code);
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      throw UserError(path_, "is not a session", "give a session.db that arborslam_offline wrote");
    case SQLITE_CORRUPT:
    case SQLITE_SCHEMA:
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
      throw UserError(path_, std::string("is damaged (") + sqlite3_errmsg(connection_.get()) + ")", kUseCopy);
    case SQLITE_FULL:
      throw UserError(path_, "could not be written completely: the disk is full",
                      "make room; what the session held before is kept");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw UserError(path_, "is in use by another program", "wait until that has ended");
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      throw UserError(path_, "cannot be opened or written (" + reason + ")",
                      "check the permissions of the file and of its folder");
    case SQLITE_NOMEM:
      throw std::bad_alloc();
    case SQLITE_IOERR:
      throw UserError(path_,
                      code == SQLITE_IOERR_READ ? "cannot be read (" + reason + ")"
                                                : "could not be written completely (" + reason + ")",
                      "check the disk; what the session held before is kept");
    default:
      // A damaged file can lack tables and columns.
      throw UserError(path_, std::string("is damaged (") + sqlite3_errmsg(connection_.get()) + ")", kUseCopy);
  }
}

void Database::Execute(const std::string& sql) {
  Check(sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr));
}

std::optional<int64_t> Database::Integer(const std::string& sql) {
  Statement statement(this, sql);
  if (!statement.Step()) return std::nullopt;
  return statement.Integer(0);
}

void Database::CopyFrom(const Database& source) {
  sqlite3_backup* backup = sqlite3_backup_init(connection_.get(), "main", source.connection_.get(), "main");
  if (backup == nullptr) Fail(sqlite3_extended_errcode(connection_.get()));
  const int step = sqlite3_backup_step(backup, -1);
  const int code = sqlite3_backup_finish(backup);
  if (step == SQLITE_DONE) return Check(code);
  Fail(step);
}

Database::Statement::Statement(Database* database, const std::string& sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  database->Check(
      sqlite3_prepare_v2(database->connection_.get(), sql.c_str(), static_cast<int>(sql.size()), &statement, nullptr));
  statement_.reset(statement);
}

Database::Statement& Database::Statement::Bind(int64_t value) {
  database_->Check(sqlite3_bind_int64(statement_.get(), ++num_bound_, value));
  return *this;
}

Database::Statement& Database::Statement::Bind(double value) {
  database_->Check(sqlite3_bind_double(statement_.get(), ++num_bound_, value));
  return *this;
}

Database::Statement& Database::Statement::BindText(std::string_view text) {
  database_->Check(
      sqlite3_bind_text64(statement_.get(), ++num_bound_, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Database::Statement& Database::Statement::BindBytes(std::string_view bytes) {
  database_->Check(sqlite3_bind_blob64(statement_.get(), ++num_bound_, bytes.data(), bytes.size(), SQLITE_TRANSIENT));
  return *this;
}

Database::Statement& Database::Statement::BindNull() {
  database_->Check(sqlite3_bind_null(statement_.get(), ++num_bound_));
  return *this;
}

bool Database::Statement::Step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  sqlite3_reset(statement_.get());
  num_bound_ = 0;
  database_->Check(code);
  return false;
}

void Database::Statement::Run() { CHECK(!Step()) << "a statement that gives no rows"; }

bool Database::Statement::IsNull(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

void Database::Statement::Expect(bool is_of_type, int column) const {
  if (is_of_type) return;
  throw UserError(
      database_->path_,
      std::string("is damaged (") + sqlite3_column_name(statement_.get(), column) + " holds a value of another type)",
      kUseCopy);
}

int64_t Database::Statement::Integer(int column) const {
  Expect(sqlite3_column_type(statement_.get(), column) == SQLITE_INTEGER, column);
  return sqlite3_column_int64(statement_.get(), column);
}

double Database::Statement::Real(int column) const {
  Expect(sqlite3_column_type(statement_.get(), column) == SQLITE_FLOAT, column);
  return sqlite3_column_double(statement_.get(), column);
}

std::string Database::Statement::Text(int column) const {
  Expect(sqlite3_column_type(statement_.get(), column) == SQLITE_TEXT, column);
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return std::string(text, static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column)));
}

std::string_view Database::Statement::Bytes(int column) const {
  Expect(sqlite3_column_type(statement_.get(), column) == SQLITE_BLOB, column);
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
  return std::string_view(bytes, static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column)));
}

}  // namespace arborslam
