#ifndef ARBORSLAM_CORE_IO_INPUT_FILE_H_
#define ARBORSLAM_CORE_IO_INPUT_FILE_H_

#include <cstddef>
#include <fstream>
#include <string>
#include <string_view>

namespace arborslam {

/// Opens the file at `path` for binary reading. Throws a `UserError` of its own kind each when it does not exist, is a
/// folder, is no regular file, is empty, or may not be read.
std::ifstream OpenInputFile(const std::string& path);

/// True if the file at `path` begins as a zip archive does. Throws as `OpenInputFile` does.
bool HasZipMagic(const std::string& path);

/// Bytes of the UTF-8 byte order mark with which `text` begins: 3, or 0 if there is none.
size_t ByteOrderMarkLength(std::string_view text);

/// `text` in quotes for an error message: one line, cut to a readable length, unprintable bytes shown as '?'.
std::string Quoted(const std::string& text);

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_INPUT_FILE_H_
