#ifndef ARBORSLAM_CORE_IO_ATOMIC_FILE_H_
#define ARBORSLAM_CORE_IO_ATOMIC_FILE_H_

#include <memory>
#include <ostream>
#include <string>
#include <string_view>

namespace arborslam {

/// A file that appears under its name only when it is whole: it is written to a temporary in the same folder, which
/// `Commit` renames over the target. Without a commit (an exception, an interrupted run) the destructor removes the
/// temporary and what stood at the target stays untouched. Use from one thread.
class AtomicFile {
 public:
  /// Creates the temporary beside `path`. Throws `UserError` when the folder is missing or not writable, or when
  /// `path` is a folder.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// The binary stream to write to, in the C locale; it cannot seek. A failed write sets its state and is reported by
  /// `Commit`.
  std::ostream& stream() { return stream_; }

  /// Whether `Commit` waits until the storage holds the file (fsync), so that it survives a power cut.
  enum class Durability { kFast, kSynced };

  /// Flushes, checks every write since opening, and renames the temporary to the target. Call it once, last. Throws
  /// `UserError` (a full disk, for one), and then the target is untouched.
  void Commit(Durability durability = Durability::kFast);

 private:
  class Buffer;

  std::string path_;
  std::string temporary_;  // Empty once it has been renamed.
  std::unique_ptr<Buffer> buffer_;
  std::ostream stream_;
};

/// Writes `contents` to `path` as an `AtomicFile`. Throws `UserError`.
void WriteFileAtomically(const std::string& path, std::string_view contents);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_ATOMIC_FILE_H_
