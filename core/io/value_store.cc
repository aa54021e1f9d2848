#include "core/io/value_store.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/error.h"

namespace arborslam {
namespace {

// Calls `step(done)`, which reads or writes from byte `done` on and says how many bytes it moved, until `size` are
// done. False, with errno, if they cannot be.
template <class Step>
bool MoveAll(size_t size, const Step& step) {
  for (size_t done = 0; done < size;) {
    const ssize_t moved = step(done);
    if (moved < 0 && errno == EINTR) continue;
    if (moved == 0) errno = EIO;
    if (moved <= 0) return false;
    done += static_cast<size_t>(moved);
  }
  return true;
}

// A new file in `folder` that has no name; -1, with errno, if there can be none.
int OpenNameless(const std::string& folder) {
  std::string name = (folder.empty() ? "." : folder) + "/arborslam_XXXXXX";
  const int file = mkostemp(name.data(), O_CLOEXEC);
  if (file >= 0) unlink(name.c_str());
  return file;
}

}  // namespace

ValueStore::ValueStore(std::string folder, size_t max_bytes) : folder_(std::move(folder)), max_bytes_(max_bytes) {}

ValueStore::~ValueStore() {
  CHECK(in_memory_.empty()) << "a value outlives its store";
  if (file_ >= 0) close(file_);
}

size_t ValueStore::bytes_in_memory() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return bytes_in_memory_;
}

uint64_t ValueStore::bytes_in_file() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return file_size_;
}

void ValueStore::Add(Slot* slot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  slot->size_ = slot->Bytes().size();
  MakeRoom(slot->size_);
  List(slot);
}

void ValueStore::Remove(Slot* slot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (slot->is_in_memory_) Unlist(slot);
}

void ValueStore::Use(Slot* slot) {
  if (slot->is_in_memory_) {
    in_memory_.splice(in_memory_.begin(), in_memory_, slot->listed_);
    return;
  }
  MakeRoom(slot->size_);
  slot->Restore(Read(*slot), folder_);
  List(slot);
}

void ValueStore::List(Slot* slot) {
  slot->listed_ = in_memory_.insert(in_memory_.begin(), slot);
  slot->is_in_memory_ = true;
  bytes_in_memory_ += slot->size_;
}

void ValueStore::Unlist(Slot* slot) {
  in_memory_.erase(slot->listed_);
  slot->is_in_memory_ = false;
  bytes_in_memory_ -= slot->size_;
}

void ValueStore::MakeRoom(size_t size) {
  while (!in_memory_.empty() && bytes_in_memory_ + size > max_bytes_) {
    Slot* const oldest = in_memory_.back();
    if (!oldest->is_in_file_) Write(oldest);
    Unlist(oldest);
    oldest->Forget();
  }
}

void ValueStore::Write(Slot* slot) {
  if (file_ < 0) file_ = OpenNameless(folder_);
  if (file_ < 0) Fail("made");
  const std::string bytes = slot->Bytes();
  const bool is_written = MoveAll(bytes.size(), [&](size_t done) {
    return pwrite(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(file_size_ + done));
  });
  if (!is_written) Fail("written");
  slot->offset_ = file_size_;
  slot->is_in_file_ = true;
  file_size_ += bytes.size();
}

std::string ValueStore::Read(const Slot& slot) const {
  std::string bytes(slot.size_, '\0');
  const bool is_read = MoveAll(bytes.size(), [&](size_t done) {
    return pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(slot.offset_ + done));
  });
  if (!is_read) Fail("read back");
  return bytes;
}

void ValueStore::Fail(const char* what) const {
  throw UserError(folder_.empty() ? "." : folder_,
                  std::string("the file of what memory.max_size leaves no room for cannot be ") + what + " (" +
                      std::strerror(errno) + ")",
                  "free space there, let TMPDIR name another folder, or raise memory.max_size");
}

}  // namespace arborslam
