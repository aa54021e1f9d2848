#include "apps/common/output_folder.h"

#include <system_error>

#include "core/error.h"
#include "core/io/atomic_file.h"

namespace arborslam {

std::filesystem::path MakeOutputFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path)) {
    const std::string reason = error ? " (" + error.message() + ")" : "";
    throw UserError(path, "cannot be made a folder" + reason, "choose another --output");
  }
  return path;
}

std::filesystem::path PrepareOutputFolder(const std::string& path, const std::vector<std::string>& results,
                                          const std::vector<std::string>& inputs) {
  const std::filesystem::path folder = MakeOutputFolder(path);
  for (const std::string& name : results) {
    const std::filesystem::path result = folder / name;
    for (const std::string& input : inputs) {
      std::error_code error;
      if (!input.empty() && std::filesystem::equivalent(input, result, error)) {
        throw UserError(input, "would be overwritten by the result of that name", "choose another --output");
      }
    }
    AtomicFile writable(result.string());
  }
  return folder;
}

}  // namespace arborslam
