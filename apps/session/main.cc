// arborslam_session: looks at session files, exports what is in them, checks them and brings old ones up to date.

#include <gflags/gflags.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/session/commands.h"
#include "core/config/edit_distance.h"

DEFINE_string(session, "", "session file");
DEFINE_string(output, "", "folder for the results of export");

namespace arborslam {
namespace {

constexpr char kUsage[] =
    R"(usage: arborslam_session COMMAND --session FILE.db [flags]

Works on the session.db that arborslam_offline writes.

  info --session FILE.db      prints what the session holds
  export --session FILE.db --output DIR
                              writes trajectory.tum, graph.g2o, map.yaml, map.pgm and map.png without the recording; of a
                              session that is not finished as if the recording had ended there, without loops closed
  verify --session FILE.db    reads all of it; one line says that it is whole or what is wrong (exit code 1)
  migrate --session FILE.db   brings a session of an older format to the present one
  --help, --version
)";

struct Command {
  std::string name;
  bool has_output;
  std::function<int()> run;
};

const std::vector<Command>& Commands() {
  static const auto* const commands = new std::vector<Command>{
      {"info", false, [] { return SessionInfo(FLAGS_session); }},
      {"export", true, [] { return SessionExport(FLAGS_session, FLAGS_output); }},
      {"verify", false, [] { return SessionVerify(FLAGS_session); }},
      {"migrate", false, [] { return SessionMigrate(FLAGS_session); }},
  };
  return *commands;
}

int Run(const std::string& name) {
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
  if (FLAGS_session.empty()) throw UsageError("--session FILE.db is missing; see --help");
  if (command->has_output && FLAGS_output.empty()) throw UsageError("--output DIR is missing; see --help");
  if (!command->has_output && !FLAGS_output.empty()) throw UsageError("--output is for export only; leave it out");
  return command->run();
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
  return arborslam::RunProgram({"arborslam_session", arborslam::kUsage, __FILE__, {}},
                               static_cast<int>(arguments.size()), arguments.data(),
                               [&command](const arborslam::MultiFlags&) { return arborslam::Run(command); });
}
