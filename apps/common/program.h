#ifndef ARBORSLAM_APPS_COMMON_PROGRAM_H_
#define ARBORSLAM_APPS_COMMON_PROGRAM_H_

#include <functional>
#include <string>
#include <vector>

#include "apps/common/command_line.h"

namespace arborslam {

/// Exit codes of every program.
enum ExitCode : int {
  kExitSuccess = 0,
  kExitFailure = 1,   ///< The work could not be done: a file, a record, a configuration.
  kExitUsage = 2,     ///< The command line is at fault.
  kExitDegraded = 3,  ///< Done, but parts of the result should not be trusted (`RunState::kDegraded`).
  kExitLost = 4,      ///< Done, but the result should not be trusted (`RunState::kLost`).
};

/// What a program is, for `RunProgram`.
struct ProgramDescription {
  std::string name;                      ///< "arborslam_evaluate".
  std::string usage;                     ///< The whole text of --help, ending with a newline.
  std::string source_file;               ///< `__FILE__` of main.cc: flags defined in its folder are the program's.
  std::vector<std::string> multi_flags;  ///< Names of the flags with several values, which gflags cannot hold.
};

/// Runs a program: reads the command line into the program's gflags, calls `body`, and turns what it throws into one
/// line on stderr, "name: error: ...", and an exit code: `UsageError` 2, any other exception 1. `--help`, `-h` and
/// `--version` print to stdout and end with 0 before anything else is looked at. glog writes warnings and errors to
/// stderr. A result that stdout does not take (a full disk) is an error too.
/// @param body gets the values of the multi flags and returns the exit code.
int RunProgram(const ProgramDescription& program, int argc, char** argv,
               const std::function<int(const MultiFlags&)>& body);

}  // namespace arborslam

#endif  // ARBORSLAM_APPS_COMMON_PROGRAM_H_
