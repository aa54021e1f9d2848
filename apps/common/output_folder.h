#ifndef ARBORSLAM_APPS_COMMON_OUTPUT_FOLDER_H_
#define ARBORSLAM_APPS_COMMON_OUTPUT_FOLDER_H_

#include <filesystem>
#include <string>
#include <vector>

namespace arborslam {

/// Makes the folder `path`, the value of --output, with those above it, if it does not exist. Throws `UserError`.
std::filesystem::path MakeOutputFolder(const std::string& path);

/// The same, and proves before hours of work that the files `results` can be written into it. Throws `UserError` also
/// when one of the paths `inputs`, of which empty ones are passed over, would be overwritten by a result.
std::filesystem::path PrepareOutputFolder(const std::string& path, const std::vector<std::string>& results,
                                          const std::vector<std::string>& inputs);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_COMMON_OUTPUT_FOLDER_H_
