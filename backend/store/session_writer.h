#ifndef ARBORSLAM_BACKEND_STORE_SESSION_WRITER_H_
#define ARBORSLAM_BACKEND_STORE_SESSION_WRITER_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/slam.h"
#include "backend/store/database.h"
#include "backend/store/session_contents.h"
#include "backend/store/session_rows.h"

namespace arborslam {

/// Gives the finished session at `source` the name `target`, in place of a file that is there, at once. Throws
/// `UserError`.
void MoveSession(const std::string& source, const std::string& target);

/// Writes a session that no run goes on with, such as a merged one, as a finished one in place of the file at `path`,
/// whole or not at all. `contents` must be such as `ReadSession` may return. Throws `UserError`.
void WriteSession(const std::string& path, const SessionContents& contents);

/// Writes a run into a session file as it goes, in transactions: whenever the program ends, be it killed, the file
/// opens again and lacks what came after the last of them at most. A new session takes its place as soon as it holds a
/// keyframe; what was there stays until then, and for good when none comes. Everything that goes wrong is a
/// `UserError`; what was written until then stays. For one thread.
class SessionWriter {
 public:
  /// Begins a session that takes the place of a file at `path`; see `SessionContents` for `config`. `input` names the
  /// recording for people.
  static std::unique_ptr<SessionWriter> Create(const std::string& path, const std::string& config,
                                               const std::string& input);
  /// Goes on with the session at `path`, which holds `contents` (as `ReadTracked` reads it) and is brought to the
  /// present format. What an end of the run had added to it is taken away with the first transaction.
  static std::unique_ptr<SessionWriter> Continue(const std::string& path, const SessionContents& contents);
  /// The same with a copy of the session at `source`, which takes the place of a file at `path` that is another one.
  static std::unique_ptr<SessionWriter> ContinueCopy(const std::string& source, const std::string& path,
                                                     const SessionContents& contents);
  ~SessionWriter();

  /// Takes what became of the scan that `slam` was given last, and, when a transaction is due, all that is new in
  /// `slam`.
  void Add(uint64_t fingerprint, const ScanResult& result, const Slam& slam);
  /// Ends the present transaction with all that is new in `slam`, whose run has not ended.
  void Commit(const Slam& slam);
  /// Closes the session and removes what was written, but leaves a file that `Continue` goes on with; nothing may
  /// follow.
  void Discard();
  /// Writes what the end of the run came to, after `Commit` and `Slam::Finish`, once, and closes the session: a single
  /// file.
  /// @param stamp_shift [s], of `FinishResult::sweep_duration`, or 0.
  void Finish(const Slam& slam, double stamp_shift);

  /// [s] between transactions.
  static constexpr double kInterval = 0.5;

 private:
  // How much of a run is in the file.
  struct Written {
    size_t read = 0;
    size_t posed = 0;
    size_t keyframes = 0;
    size_t submaps = 0;
    size_t submap_nodes = 0;
    size_t constraints = 0;
    bool may_have_end = false;  // What `Finish` writes.
    std::vector<NodeId> open;   // Poses that may have moved since.
  };

  SessionWriter(const std::string& path, const std::string& file, Written written);

  static std::unique_ptr<SessionWriter> Opened(const std::string& path, const std::string& file, Written written);
  // All of a session.
  static Written WrittenOf(const SessionContents& contents);

  void Open();
  void Close();
  bool IsInPlace() const { return file_ == path_; }
  bool IsWorthItsPlace(const Slam& slam) const;
  void MoveIntoPlace();
  void Begin();
  void WritePoses(const Slam& slam);

  std::string path_;
  std::string file_;                   // Where the session is at present: `path_`, or a new name beside it.
  bool is_own_;                        // False: the file was there before.
  std::optional<Database> database_;   // Until it is closed.
  std::unique_ptr<SessionRows> rows_;  // Of the database.
  Written written_;
  bool in_transaction_ = false;
  std::chrono::steady_clock::time_point last_commit_ = std::chrono::steady_clock::now();
};

}  // namespace arborslam

#endif  // ARBORSLAM_BACKEND_STORE_SESSION_WRITER_H_
