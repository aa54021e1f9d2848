#include <iostream>
#include <vector>

#include "apps/offline/loaded_session.h"
#include "apps/session/commands.h"
#include "backend/store/session_reader.h"
#include "core/error.h"

namespace arborslam {

int SessionVerify(const std::string& path) {
  // Content first: what it says of a damaged file is closer to the user.
  const bool is_finished = ReadSessionSummary(path).is_finished;
  const LoadedSession session = LoadSession(path);
  // What was tracked must serve to go on, too, where a run can.
  if (is_finished && session.contents.recordings.size() == 1) {
    Completed(ReadTracked(path), session.options.slam, path);
  }
  const std::vector<std::string> problems = DatabaseProblems(path);
  if (!problems.empty()) {
    throw UserError(path, "is damaged (" + problems.front() + ")", "use a copy, or map the recording again");
  }
  std::cout << path << ": whole, " << session.contents.read.size() << " scans, " << session.contents.keyframes.size()
            << " keyframes, " << (is_finished ? "finished" : "not finished") << "\n";
  return 0;
}

}  // namespace arborslam
