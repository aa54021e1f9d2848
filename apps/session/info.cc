#include <array>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>

#include "apps/session/commands.h"
#include "backend/store/session_format.h"
#include "backend/store/session_reader.h"

namespace arborslam {

namespace {

// Each with its span of time: the stamps of recordings have nothing to do with each other.
std::string RecordingLines(const SessionContents& contents) {
  std::ostringstream lines;
  lines << std::fixed << std::setprecision(3);
  size_t begin = 0;
  for (const SessionContents::Recording& recording : contents.recordings) {
    lines << "recording    " << recording.name << "\n";
    const size_t end = begin + recording.num_posed;
    if (end > begin) {
      lines << "stamps       " << contents.scans[begin].stamp << " to " << contents.scans[end - 1].stamp << " s\n";
    }
    begin = end;
  }
  return lines.str();
}

}  // namespace

int SessionInfo(const std::string& path) {
  const SessionSummary summary = ReadSessionSummary(path);
  const SessionContents contents = ReadSession(path);
  std::array<size_t, 3> constraints{};
  for (const Constraint& constraint : contents.graph.constraints())
    ++constraints.at(static_cast<size_t>(constraint.kind));
  std::cout << "session      " << path << "\n"
            << "format       " << summary.format
            << (summary.format < kSessionFormat ? " (older than the present one)" : "") << "\n"
            << RecordingLines(contents) << "state        "
            << (summary.is_finished ? "finished" : "not finished: arborslam_offline --session goes on") << "\n"
            << "scans        " << contents.read.size() << ", " << contents.scans.size() << " with a pose\n"
            << "keyframes    " << contents.keyframes.size() << "\n"
            << "submaps      " << contents.submaps.size() << "\n"
            << "constraints  " << constraints[0] << " to submaps, " << constraints[1] << " of the motion, "
            << constraints[2] << " at the end (loops, and all scans to the corrected maps)\n";
  return 0;
}

}  // namespace arborslam
