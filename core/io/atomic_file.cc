#include "core/io/atomic_file.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <locale>
#include <streambuf>
#include <system_error>
#include <vector>

#include "core/error.h"

namespace arborslam {
namespace {

constexpr size_t kBufferSize = 1 << 16;
constexpr int kMaxAttempts = 10000;
constexpr char kRemedy[] = "check that the folder exists, can be written to and has space, or choose another path";

std::string ErrnoText(int error) { return std::generic_category().message(error); }

std::string FolderOf(const std::string& path) {
  const size_t slash = path.rfind('/');
  return slash == std::string::npos ? "./" : path.substr(0, slash + 1);
}

}  // namespace

// std::ofstream tells neither errno nor the descriptor, and both are needed here.
class AtomicFile::Buffer : public std::streambuf {
 public:
  explicit Buffer(int descriptor) : descriptor_(descriptor), pending_(kBufferSize) {
    setp(pending_.data(), pending_.data() + pending_.size());
  }
  ~Buffer() override { Close(); }

  // The errno of the first operation that failed, or 0.
  int error() const { return error_; }

  void Synchronize() {
    if (error_ == 0 && ::fsync(descriptor_) != 0) error_ = errno;
  }

  void Close() {
    if (descriptor_ < 0) return;
    // Network file systems report a failed write no earlier than here.
    if (::close(descriptor_) != 0 && error_ == 0) error_ = errno;
    descriptor_ = -1;
  }

 protected:
  int_type overflow(int_type character) override {
    if (!Flush()) return traits_type::eof();
    if (!traits_type::eq_int_type(character, traits_type::eof())) {
      *pptr() = traits_type::to_char_type(character);
      pbump(1);
    }
    return traits_type::not_eof(character);
  }

  int sync() override { return Flush() ? 0 : -1; }

 private:
  bool Flush() {
    const char* begin = pbase();
    while (error_ == 0 && begin != pptr()) {
      const ssize_t written = ::write(descriptor_, begin, static_cast<size_t>(pptr() - begin));
      if (written >= 0) {
        begin += written;
      } else if (errno != EINTR) {
        error_ = errno;
      }
    }
    setp(pending_.data(), pending_.data() + pending_.size());
    return error_ == 0;
  }

  int descriptor_;
  int error_ = 0;
  std::vector<char> pending_;
};

AtomicFile::AtomicFile(const std::string& path) : path_(path), stream_(nullptr) {
  struct stat status;
  if (::stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) {
    throw UserError(path, "cannot be written: it is a folder", "give the name of a file");
  }
  // O_EXCL on names of our own instead of mkstemp, whose files only the owner may read.
  int descriptor = -1;
  for (int attempt = 0; descriptor < 0; ++attempt) {
    temporary_ = FolderOf(path) + ".arborslam-" + std::to_string(::getpid()) + "-" + std::to_string(attempt) + ".tmp";
    descriptor = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0 && errno != EINTR && (errno != EEXIST || attempt == kMaxAttempts)) {
      throw UserError(path, "cannot be written: " + ErrnoText(errno), kRemedy);
    }
  }
  buffer_ = std::make_unique<Buffer>(descriptor);
  stream_.rdbuf(buffer_.get());
  // A user's locale must not put commas into numbers.
  stream_.imbue(std::locale::classic());
}

AtomicFile::~AtomicFile() {
  stream_.rdbuf(nullptr);
  buffer_->Close();
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::Commit(Durability durability) {
  CHECK(!temporary_.empty()) << "AtomicFile " << path_ << " was committed before";
  stream_.flush();
  if (durability == Durability::kSynced) buffer_->Synchronize();
  buffer_->Close();
  if (buffer_->error() != 0) {
    throw UserError(path_, "could not be written completely: " + ErrnoText(buffer_->error()), kRemedy);
  }
  if (!stream_) throw UserError(path_, "could not be written completely: the output stream failed", kRemedy);
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    throw UserError(path_, "cannot be written: " + ErrnoText(errno), kRemedy);
  }
  temporary_.clear();
  if (durability == Durability::kSynced) {
    // The rename itself lives in the folder.
    const int folder = ::open(FolderOf(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return;
    ::fsync(folder);
    ::close(folder);
  }
}

void WriteFileAtomically(const std::string& path, std::string_view contents) {
  AtomicFile file(path);
  file.stream().write(contents.data(), static_cast<std::streamsize>(contents.size()));
  file.Commit();
}

}  // namespace arborslam
