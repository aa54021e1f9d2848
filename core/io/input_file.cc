#include "core/io/input_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/error.h"

namespace arborslam {

std::ifstream OpenInputFile(const std::string& path) {
  struct stat status;
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) throw UserError(path, "does not exist", "check the path");
    throw UserError(path, "cannot be read: " + std::generic_category().message(errno), "check the path");
  }
  if (S_ISDIR(status.st_mode)) throw UserError(path, "is a folder", "give the path of a file");
  if (!S_ISREG(status.st_mode)) throw UserError(path, "is not a regular file", "copy its contents to a file first");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw UserError(path, "cannot be read: " + std::generic_category().message(errno), "check its permissions");
  }
  if (status.st_size == 0) throw UserError(path, "is empty", "check that it was copied completely");
  return stream;
}

bool HasZipMagic(const std::string& path) {
  std::ifstream stream = OpenInputFile(path);
  char magic[4] = {};
  stream.read(magic, sizeof(magic));
  // A local file header, or the end record that is all an archive without entries has.
  return magic[0] == 'P' && magic[1] == 'K' &&
         ((magic[2] == '\3' && magic[3] == '\4') || (magic[2] == '\5' && magic[3] == '\6'));
}

size_t ByteOrderMarkLength(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.substr(0, kMark.size()) == kMark ? kMark.size() : 0;
}

std::string Quoted(const std::string& text) {
  constexpr size_t kMaxLength = 40;
  std::string shown = text.substr(0, kMaxLength);
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + shown + (text.size() > kMaxLength ? "..." : "") + "'";
}

}  // namespace arborslam
