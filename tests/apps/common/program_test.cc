#include "apps/common/program.h"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/common/version.h"
#include "core/error.h"

namespace arborslam {
namespace {

struct Outcome {
  int exit_code;
  std::string out;
  std::string err;
};

Outcome RunWith(std::vector<std::string> arguments, const std::function<int(const MultiFlags&)>& body) {
  arguments.insert(arguments.begin(), "program");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit_code = RunProgram({"arborslam_test", "usage: arborslam_test\n", "/nowhere/main.cc", {"set"}},
                                   static_cast<int>(arguments.size()), argv.data(), body);
  Outcome outcome{exit_code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
  return outcome;
}

int Unexpected(const MultiFlags&) {
  ADD_FAILURE() << "the body must not run";
  return 0;
}

TEST(RunProgramTest, HelpAndVersionComeBeforeAnythingElse) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--help"}, {"-h"}, {"--nonsense", "stray", "--help"}, {"--set", "-h"}}) {
    const Outcome outcome = RunWith(arguments, &Unexpected);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(outcome.out, "usage: arborslam_test\n");
    EXPECT_EQ(outcome.err, "");
  }
  const Outcome version = RunWith({"--version"}, &Unexpected);
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out, std::string("arborslam_test ") + kVersion + "\n");
}

TEST(RunProgramTest, TheBodyGetsMultiFlagsAndItsExitCodeIsReturned) {
  std::vector<std::string> values;
  const Outcome outcome = RunWith({"--set", "a=1", "--set=b=2"}, [&](const MultiFlags& flags) {
    values = flags.at("set");
    return 3;
  });
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(values, (std::vector<std::string>{"a=1", "b=2"}));
  RunWith({}, [&](const MultiFlags& flags) {
    EXPECT_TRUE(flags.at("set").empty());
    return 0;
  });
}

TEST(RunProgramTest, EveryErrorIsOneLineWithItsExitCode) {
  const auto throwing = [](const auto& error) { return [error](const MultiFlags&) -> int { throw error; }; };
  Outcome outcome = RunWith({}, throwing(UserError("a.tum:3", "has 7 columns", "give 8")));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "arborslam_test: error: a.tum:3: has 7 columns; give 8\n");
  outcome = RunWith({}, throwing(std::runtime_error("two\nlines\r\n")));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "arborslam_test: error: two lines  \n");
  outcome = RunWith({}, throwing(std::bad_alloc()));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.err, "arborslam_test: error: out of memory\n");
  outcome = RunWith({}, throwing(UsageError("--input is missing")));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, "arborslam_test: error: --input is missing\n");
}

TEST(RunProgramTest, ABadCommandLineNeverReachesTheBody) {
  Outcome outcome = RunWith({"--sett", "a=1"}, &Unexpected);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, "arborslam_test: error: unknown flag --sett; the nearest is --set, all are in --help\n");
  outcome = RunWith({"--set"}, &Unexpected);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, "arborslam_test: error: --set needs at least one value\n");
  outcome = RunWith({"stray"}, &Unexpected);
  EXPECT_EQ(outcome.exit_code, 2);
}

}  // namespace
}  // namespace arborslam
