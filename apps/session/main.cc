// arborslam_session: looks at session files, exports what is in them, merges them, checks them and brings old ones up
// to date.

#include <gflags/gflags.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/session/commands.h"
#include "core/config/edit_distance.h"

DEFINE_string(output, "", "folder for the results of export and merge");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_session COMMAND --session FILE.db [flags]

Works on the session.db that arborslam_offline writes.

  info --session FILE.db      prints what the session holds
  export --session FILE.db --output DIR
                              writes trajectory.tum, graph.g2o, map.yaml, map.pgm and map.png without the recording; of
                              a session that is not finished as if the recording had ended there, without loops closed;
                              of a merged one trajectory_1.tum, trajectory_2.tum, ..., one for each recording
  merge --session FILE.db FILE.db [...] --output DIR [--set SECTION.KEY=VALUE ...]
                              makes one map of sessions of one site whose paths overlap, in the frame of the first one;
                              how they lie to each other need not be known. All must be of one kind of lidar and made
                              with the same options. Writes session.db, which all programs take (further recordings:
                              arborslam_offline --session), and what export writes. --set: options over those of the
                              sessions; there is also a section 'merge'. When a session has no certain
                              place among those before it, nothing is written (exit code 1)
  verify --session FILE.db    reads all of it; one line says that it is whole or what is wrong (exit code 1)
  migrate --session FILE.db   brings a session of an older format to the present one
  --help, --version
)";

constexpr char kMerge[] = "merge";

struct Command {
  std::string name;
  bool has_output;
  std::function<int(const MultiFlags&)> run;
};

const std::string& Session(const MultiFlags& flags) { return flags.at("session").front(); }

const std::vector<Command>& Commands() {
  static const auto* const commands = new std::vector<Command>{
      {"info", false, [](const MultiFlags& flags) { return SessionInfo(Session(flags)); }},
      {"export", true, [](const MultiFlags& flags) { return SessionExport(Session(flags), FLAGS_output); }},
      {kMerge, true,
       [](const MultiFlags& flags) { return SessionMerge(flags.at("session"), FLAGS_output, flags.at("set")); }},
      {"verify", false, [](const MultiFlags& flags) { return SessionVerify(Session(flags)); }},
      {"migrate", false, [](const MultiFlags& flags) { return SessionMigrate(Session(flags)); }},
  };
  return *commands;
}

int Run(const std::string& name, const MultiFlags& flags) {
  std::vector<std::string> names;
  std::string list;
  for (const Command& command : Commands()) {
    names.push_back(command.name);
    list += (list.empty() ? "" : ", ") + command.name;
  }
  if (name.empty()) throw UsageError("the command is missing; there are: " + list);
  const auto command = std::find_if(Commands().begin(), Commands().end(),
                                    [&name](const Command& candidate) { return candidate.name == name; });
  if (command == Commands().end()) {
    throw UsageError("the command is '" + name + "'; did you mean '" + NearestName(name, names) +
                     "'? There are: " + list);
  }
  const size_t num_sessions = flags.at("session").size();
  if (num_sessions == 0) throw UsageError("--session FILE.db is missing; see --help");
  if (num_sessions > 1 && name != kMerge) {
    throw UsageError("--session has " + std::to_string(num_sessions) + " files, but " + name + " takes one");
  }
  if (!flags.at("set").empty() && name != kMerge) throw UsageError("--set is for merge only; leave it out");
  if (command->has_output && FLAGS_output.empty()) throw UsageError("--output DIR is missing; see --help");
  if (!command->has_output && !FLAGS_output.empty()) {
    throw UsageError("--output is for export and merge only; leave it out");
  }
  return command->run(flags);
}

}  // namespace
}  // namespace arborslam

int main(int argc, char** argv) {
  // The command is the first argument; what follows are flags.
  std::string command;
  std::vector<char*> arguments(argv, argv + argc);
  if (argc > 1 && argv[1][0] != '-') {
    command = argv[1];
    arguments.erase(arguments.begin() + 1);
  }
  return arborslam::RunProgram(
      {"arborslam_session", arborslam::kUsage, __FILE__, {"session", "set"}}, static_cast<int>(arguments.size()),
      arguments.data(), [&command](const arborslam::MultiFlags& flags) { return arborslam::Run(command, flags); });
}
