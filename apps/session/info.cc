#include <array>
#include <iomanip>
#include <iostream>

#include "apps/session/commands.h"
#include "backend/store/session_format.h"
#include "backend/store/session_reader.h"

namespace arborslam {

int SessionInfo(const std::string& path) {
  const SessionSummary summary = ReadSessionSummary(path);
  const SessionContents contents = ReadSession(path);
  std::array<size_t, 3> constraints{};
  for (const Constraint& constraint : contents.graph.constraints())
    ++constraints.at(static_cast<size_t>(constraint.kind));
  std::cout << "session      " << path << "\n"
            << "format       " << summary.format
            << (summary.format < kSessionFormat ? " (older than the present one)" : "") << "\n"
            << "recording    " << summary.input << "\n"
            << "state        "
            << (summary.is_finished ? "finished" : "not finished: arborslam_offline --session goes on") << "\n"
            << "scans        " << contents.read.size() << ", " << contents.scans.size() << " with a pose\n"
            << "keyframes    " << contents.keyframes.size() << "\n"
            << "submaps      " << contents.submaps.size() << "\n"
            << "constraints  " << constraints[0] << " to submaps, " << constraints[1] << " of the motion, "
            << constraints[2] << " at the end (loops, and all scans to the corrected maps)\n";
  if (!contents.scans.empty()) {
    std::cout << "stamps       " << std::fixed << std::setprecision(3) << contents.scans.front().stamp << " to "
              << contents.scans.back().stamp << " s\n";
  }
  return 0;
}

}  // namespace arborslam
