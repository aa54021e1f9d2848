#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/common/output_folder.h"
#include "apps/session/commands.h"
#include "apps/session/loaded_session.h"
#include "apps/session/session_outputs.h"
#include "backend/merge/session_merger.h"
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

bool IsSpatial(const NamedSession& session) {
  return !session.session.contents.keyframes.front().scan.point_rays_are_free;
}

// A recording that is given twice would agree with itself in every error.
void RequireOtherRecordings(const NamedSession& first, const NamedSession& other) {
  std::set<uint64_t> known;
  for (const SessionContents::ReadScan& scan : first.session.contents.read) known.insert(scan.fingerprint);
  for (const SessionContents::ReadScan& scan : other.session.contents.read) {
    if (scan.fingerprint == 0 || known.count(scan.fingerprint) == 0) continue;
    throw UserError(other.path, "holds scans that " + first.path + " holds already", "give each recording once");
  }
}

std::vector<NamedSession> LoadSessions(const std::vector<std::string>& paths) {
  std::vector<NamedSession> sessions;
  for (const std::string& path : paths) {
    NamedSession session{path, LoadSession(path)};
    if (session.session.contents.keyframes.empty()) {
      throw UserError(path, "holds no keyframes yet", "leave it out, or map its recording first");
    }
    for (const NamedSession& other : sessions) {
      RequireOtherRecordings(other, session);
      if (IsSpatial(session) != IsSpatial(other)) {
        throw UserError(path,
                        IsSpatial(session) ? "was made from sweeps in space, but " + other.path + " from planar scans"
                                           : "was made from planar scans, but " + other.path + " from sweeps in space",
                        "merge sessions of one kind of lidar");
      }
      RequireSameOptions(other, session);
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

std::string TextOf(const SE2& pose) {
  char text[96];
  std::snprintf(text, sizeof(text), "(%.3f m, %.3f m, %.4f rad)", pose.x(), pose.y(), pose.theta());
  return text;
}

std::string TextOf(const PlaceVotes& votes) {
  return std::to_string(votes.num_asked) + " keyframes asked, " + std::to_string(votes.num_recognized) +
         " recognised a place, " + std::to_string(votes.agreeing.size()) + " agree on one, " +
         std::to_string(votes.num_rivals) + " on another";
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

std::string LoopsText(const std::vector<NamedSession>& sessions, const GlobalSolution& solution,
                      const SessionContents& merged) {
  // By number: keyframes are counted on from session to session, and a submap is of one session.
  std::vector<size_t> session_of_keyframe;
  for (size_t i = 0; i < sessions.size(); ++i) {
    session_of_keyframe.resize(session_of_keyframe.size() + sessions[i].session.contents.keyframes.size(), i);
  }
  const auto session_of = [&](KeyframeId id) { return session_of_keyframe[static_cast<size_t>(id.value)]; };
  std::map<int, size_t> session_of_submap;
  for (const Submap& submap : merged.submaps) session_of_submap[submap.id.value] = session_of(submap.keyframes.front());
  size_t num_tried = 0;
  size_t num_accepted = 0;
  for (const LoopCandidate& loop : solution.loops) {
    if (session_of_submap.at(loop.submap.value) == session_of(loop.keyframe)) continue;
    ++num_tried;
    num_accepted += loop.accepted ? 1 : 0;
  }
  return "loops across sessions: " + std::to_string(num_accepted) + " accepted of " + std::to_string(num_tried) +
         " tried; of all loops " + std::to_string(solution.loop_optimization.dropped_loops.size()) + " were dropped\n";
}

}  // namespace

int SessionMerge(const std::vector<std::string>& paths, const std::string& folder_name,
                 const std::vector<std::string>& assignments) {
  if (paths.size() < 2) {
    throw UsageError("--session has " + std::to_string(paths.size()) + " file, but merge needs at least two");
  }
  const std::vector<NamedSession> sessions = LoadSessions(paths);
  OfflineOptions options = sessions.front().session.options;
  PlaceOptions place;
  MergeOptions merge;
  ConfigSchema schema;
  options.VisitSections([&schema](const std::string& name, auto& section) { schema.AddSection(name, &section); });
  ConfigSchema with_merge = schema;
  with_merge.AddSection("place", &place);
  with_merge.AddSection("merge", &merge);
  for (const std::string& assignment : assignments) with_merge.ApplyOverride(assignment);
  with_merge.ValidateAll();

  SessionMerger merger(options.slam, place, merge, std::max(1, static_cast<int>(std::thread::hardware_concurrency())),
                       sessions.front().session.contents);
  AddAll(sessions, &merger);

  std::vector<std::string> names = SessionOutputNames(merger.merged().recordings.size());
  names.emplace_back(kSessionFile);
  const std::filesystem::path folder = PrepareOutputFolder(folder_name, names, paths);
  const GlobalSolution solution = merger.Finish();
  LoadedSession merged{options, merger.merged()};
  merged.contents.config = schema.ToYaml();
  WriteSession((folder / kSessionFile).string(), merged.contents);
  WriteSessionOutputs(folder, merged);
  std::cout << LoopsText(sessions, solution, merged.contents) << merged.contents.recordings.size() << " recordings, "
            << merged.contents.scans.size() << " scans with a pose; results in " << folder.string() << "\n";
  return 0;
}

}  // namespace arborslam
