#ifndef ARBORSLAM_APPS_COMMON_COMMAND_LINE_H_
#define ARBORSLAM_APPS_COMMON_COMMAND_LINE_H_

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace arborslam {

/// A command line that the program cannot work with: it ends with exit code 2 and `what()` as its one line.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The values of the flags that may have several, by the flag's name without its dashes. Every such flag has an entry,
/// empty when it was not given.
using MultiFlags = std::map<std::string, std::vector<std::string>>;

/// Takes every occurrence of the flag `name` with its values out of `arguments` (the command line without the program)
/// and returns the values in order. The values of `--name` are all arguments up to the next that starts with "--";
/// `--name=value` has the one value, and those that follow it up to the next "--". Throws `UsageError` when an
/// occurrence has no value.
std::vector<std::string> ExtractMultiFlag(std::vector<std::string>* arguments, const std::string& name);

/// Sets the gflags of the program from `arguments`: `--flag value`, `--flag=value`, for a boolean also `--flag` and
/// `--noflag`. Where a flag is given twice the last one counts.
/// @param known the names of the flags that the program defines. gflags' and other libraries' own are not offered.
/// @param also_known further names for the suggestion in the error about an unknown flag.
/// Throws `UsageError` on an unknown flag (naming the nearest), a missing or an unsuitable value, and an argument that
/// belongs to no flag.
void SetFlags(const std::vector<std::string>& arguments, const std::vector<std::string>& known,
              const std::vector<std::string>& also_known);

/// The names of the gflags that are defined in the folder of `source_file` (pass `__FILE__`).
std::vector<std::string> FlagsDefinedBeside(const std::string& source_file);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_COMMON_COMMAND_LINE_H_
