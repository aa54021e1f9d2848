#ifndef ARBORSLAM_TESTS_CORE_IO_TEMP_FOLDER_H_
#define ARBORSLAM_TESTS_CORE_IO_TEMP_FOLDER_H_

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.h"

namespace arborslam {

/// A folder of the running test's own, removed with all it holds when the test ends.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern = testing::TempDir() + "/arborslam-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot create " + pattern);
    path_ = pattern;
  }
  ~TempFolder() { std::filesystem::remove_all(path_); }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string File(const std::string& name) const { return path_ + "/" + name; }

  /// Writes `contents` to the file `name` of this folder and returns its path.
  std::string Write(const std::string& name, const std::string& contents) const {
    std::ofstream(File(name), std::ios::binary) << contents;
    return File(name);
  }

  /// The names of everything in the folder, hidden files too, sorted.
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  std::string path_;
};

inline std::string ReadWhole(const std::string& path) {
  std::ostringstream contents;
  contents << std::ifstream(path, std::ios::binary).rdbuf();
  return contents.str();
}

/// The message of the `UserError` that `action` throws, or a text no expectation matches when it throws none.
template <typename Action>
std::string UserErrorOf(const Action& action) {
  try {
    action();
  } catch (const UserError& error) {
    return error.what();
  }
  return "(no UserError)";
}

/// The folder with the recordings, which a fresh clone does not have.
inline std::string DataFolder() {
  const char* folder = std::getenv("ARBORSLAM_DATA");
  return folder != nullptr ? folder : ARBORSLAM_SOURCE_DIR "/../shared/data";
}

}  // namespace arborslam

#endif  // ARBORSLAM_TESTS_CORE_IO_TEMP_FOLDER_H_
