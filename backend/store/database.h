#ifndef ARBORSLAM_BACKEND_STORE_DATABASE_H_
#define ARBORSLAM_BACKEND_STORE_DATABASE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace arborslam {

/// An SQLite file. Whatever is wrong with the file or its storage is a `UserError` that names it. For one thread.
class Database {
 public:
  enum class Mode {
    kRead,    ///< Of a file that exists; works in folders that may not be written, too.
    kWrite,   ///< The same for changing it.
    kCreate,  ///< A new file, or one to overwrite nothing of.
    kMemory,  ///< No file: `path` only names it in errors.
  };

  Database(std::string path, Mode mode);

  const std::string& path() const { return path_; }

  /// Runs statements that give no rows that matter.
  void Execute(const std::string& sql);
  /// The first column of the first row that `sql` gives, as a number; nothing when there is no row.
  std::optional<int64_t> Integer(const std::string& sql);

  /// Copies all of `source` over this database.
  void CopyFrom(const Database& source);

  /// A statement to run once for each set of values. It must not outlive its database.
  class Statement {
   public:
    Statement(Database* database, const std::string& sql);

    /// Values of the next run's parameters, from the left; nothing: NULL.
    Statement& Bind(int64_t value);
    Statement& Bind(double value);
    Statement& BindText(std::string_view text);
    Statement& BindBytes(std::string_view bytes);
    Statement& BindNull();

    /// Goes to the next row; false after the last one, and the statement can be run anew.
    bool Step();
    /// Runs a statement that gives no rows.
    void Run();

    // Columns of the present row, from 0. Values of another type are a `UserError`: the file is damaged.
    bool IsNull(int column) const;
    int64_t Integer(int column) const;
    double Real(int column) const;
    std::string Text(int column) const;
    /// Valid until the next step.
    std::string_view Bytes(int column) const;

   private:
    void Expect(bool is_of_type, int column) const;

    struct Finalizer {
      void operator()(sqlite3_stmt* statement) const;
    };
    Database* database_;
    std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
    int num_bound_ = 0;
  };

 private:
  struct Closer {
    void operator()(sqlite3* connection) const;
  };

  int Open(const std::string& name, int flags);
  void OpenToRead();
  void Check(int code) const;
  [[noreturn]] void Fail(int code) const;

  std::string path_;
  std::unique_ptr<sqlite3, Closer> connection_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_DATABASE_H_
