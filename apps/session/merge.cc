#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/output_folder.h"
#include "apps/offline/loaded_session.h"
#include "apps/session/commands.h"
#include "apps/session/session_outputs.h"
#include "backend/merge/known_scans.h"
#include "backend/merge/session_merger.h"
#include "backend/store/session_reader.h"
#include "backend/store/session_writer.h"
#include "core/config/config_schema.h"
#include "core/error.h"

namespace arborslam {
namespace {

constexpr char kSessionFile[] = "session.db";

struct NamedSession {
  std::string path;
  LoadedSession session;
};

// Every option that a map depends on, as "section.key" and its value.
std::vector<std::pair<std::string, std::string>> MappingOptions(OfflineOptions options) {
  std::vector<std::pair<std::string, std::string>> values;
  options.slam.VisitSections([&values](const std::string& section, auto& fields) {
    fields.VisitFields([&](const std::string& key, auto& value) {
      values.emplace_back(section + "." + key, nlohmann::json(value).dump());
    });
  });
  return values;
}

void RequireSameOptions(const NamedSession& first, const NamedSession& other) {
  const auto values = MappingOptions(first.session.options);
  const auto other_values = MappingOptions(other.session.options);
  const auto [value, other_value] = std::mismatch(values.begin(), values.end(), other_values.begin());
  if (value == values.end()) return;
  throw UserError(other.path,
                  "was made with " + other_value->first + " = " + other_value->second + ", but " + first.path +
                      " with " + value->second,
                  "map one of the recordings again with the other's options");
}

void RequireOtherRecordings(const NamedSession& first, const NamedSession& other) {
  const KnownScans known(first.session.contents);
  for (const SessionContents::ReadScan& scan : other.session.contents.read) {
    if (!known.Hold(scan.fingerprint)) continue;
    throw UserError(other.path, "holds scans that " + first.path + " holds already", "give each recording once");
  }
}

std::vector<NamedSession> LoadSessions(const std::vector<std::string>& paths,
                                       const std::shared_ptr<ValueStore>& store) {
  std::vector<NamedSession> sessions;
  for (const std::string& path : paths) {
    NamedSession session{path, LoadSession(path, store)};
    if (session.session.contents.keyframes.empty()) {
      throw UserError(path, "holds no keyframes yet", "leave it out, or map its recording first");
    }
    for (const NamedSession& other : sessions) {
      RequireOtherRecordings(other, session);
      const bool is_spatial = IsSpatial(session.session.contents);
      if (is_spatial != IsSpatial(other.session.contents)) {
        throw UserError(path,
                        is_spatial ? "was made from sweeps in space, but " + other.path + " from planar scans"
                                   : "was made from planar scans, but " + other.path + " from sweeps in space",
                        "merge sessions of one kind of lidar");
      }
      RequireSameOptions(other, session);
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

// Adds all but the first session. Throws `UserError` when one finds no place.
void AddAll(const std::vector<NamedSession>& sessions, SessionMerger* merger) {
  for (size_t i = 1; i < sessions.size(); ++i) {
    const PlaceVotes votes = merger->Add(sessions[i].session.contents);
    if (!votes.reason.empty()) {
      throw UserError(sessions[i].path,
                      "has no certain place in the map of " + sessions.front().path +
                          (i > 1 ? " and those after it" : "") + " (" + TextOf(votes) + ": " + votes.reason + ")",
                      "give sessions of one site, each with a path that overlaps with one before it");
    }
    std::cout << sessions[i].path << " lies at " << TextOf(votes.T_a_b) << ": " << TextOf(votes) << "\n";
  }
}

std::string LoopsText(const MergeSolution& solution) {
  const auto num_dropped = std::count_if(solution.loops.begin(), solution.loops.end(),
                                         [](const LoopCandidate& loop) { return loop.reason == kContradictsOthers; });
  return "loops across sessions: " + std::to_string(solution.num_cross_accepted) + " accepted of " +
         std::to_string(solution.num_cross_tried) + " tried; of all loops " + std::to_string(num_dropped) +
         " contradict the others and were dropped\n";
}

}  // namespace

int SessionMerge(const std::vector<std::string>& paths, const std::string& folder_name,
                 const std::vector<std::string>& assignments) {
  if (paths.size() < 2) {
    throw UsageError("--session has " + std::to_string(paths.size()) + " file, but merge needs at least two");
  }
  OfflineOptions options = SessionOptions(ReadSessionSummary(paths.front()).config, paths.front());
  MergeOptions merge;
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) { schema.AddSection(name, &section); });
  ConfigSchema with_merge = schema;
  with_merge.AddSection("merge", &merge);
  for (const std::string& assignment : assignments) with_merge.ApplyOverride(assignment);
  with_merge.ValidateAll();
  const std::vector<NamedSession> sessions = LoadSessions(paths, MakeStore(options.memory));

  SessionMerger merger(options.slam, merge, std::max(1, static_cast<int>(std::thread::hardware_concurrency())),
                       sessions.front().session.contents);
  AddAll(sessions, &merger);

  std::vector<std::string> names = SessionOutputNames(merger.merged().recordings.size());
  names.emplace_back(kSessionFile);
  const std::filesystem::path folder = PrepareOutputFolder(folder_name, names, paths);
  const MergeSolution solution = merger.Finish();
  LoadedSession merged{options, merger.merged()};
  merged.contents.config = schema.ToYaml();
  WriteSession((folder / kSessionFile).string(), merged.contents);
  WriteSessionOutputs(folder, merged);
  std::cout << LoopsText(solution) << merged.contents.recordings.size() << " recordings, "
            << merged.contents.scans.size() << " scans with a pose; results in " << folder.string() << "\n";
  return 0;
}

}  // namespace arborslam
