#include "apps/common/program.h"

#include <glog/logging.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <new>

#include "apps/common/version.h"
#include "core/freed_memory.h"

#ifdef __SANITIZE_ADDRESS__
// Fontconfig loses one pattern for each font that cairo loads, once a process: not ours to mend.
extern "C" {
const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }
const char* __lsan_default_options();
const char* __lsan_default_options() { return "print_suppressions=0"; }
}
#endif

namespace arborslam {
namespace {

bool IsGiven(const std::vector<std::string>& arguments, const std::string& flag) {
  return std::find(arguments.begin(), arguments.end(), flag) != arguments.end();
}

int Fail(const ProgramDescription& program, std::string message, ExitCode code) {
  // A quoted value may hold line breaks, yet scripts rely on one line an error.
  for (char& character : message) {
    if (static_cast<unsigned char>(character) < ' ') character = ' ';
  }
  std::cout.flush();
  std::cerr << program.name << ": error: " << message << std::endl;
  return code;
}

void StartLogging(const ProgramDescription& program) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_WARNING;
  if (!google::IsGoogleLoggingInitialized()) google::InitGoogleLogging(program.name.c_str());
}

}  // namespace

int RunProgram(const ProgramDescription& program, int argc, char** argv,
               const std::function<int(const MultiFlags&)>& body) {
  KeepFreedMemory();
  try {
    std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
    int exit_code = kExitSuccess;
    if (IsGiven(arguments, "--help") || IsGiven(arguments, "-h")) {
      std::cout << program.usage;
    } else if (IsGiven(arguments, "--version")) {
      std::cout << program.name << " " << kVersion << "\n";
    } else {
      StartLogging(program);
      MultiFlags multi_flags;
      for (const std::string& name : program.multi_flags) multi_flags[name] = ExtractMultiFlag(&arguments, name);
      std::vector<std::string> also_known = program.multi_flags;
      also_known.insert(also_known.end(), {"help", "version"});
      SetFlags(arguments, FlagsDefinedBeside(program.source_file), also_known);
      exit_code = body(multi_flags);
    }
    if (!std::cout.flush()) return Fail(program, "standard output could not be written completely", kExitFailure);
    return exit_code;
  } catch (const UsageError& error) {
    return Fail(program, error.what(), kExitUsage);
  } catch (const std::bad_alloc&) {
    return Fail(program, "out of memory", kExitFailure);
  } catch (const std::exception& error) {
    return Fail(program, error.what(), kExitFailure);
  }
}

}  // namespace arborslam
