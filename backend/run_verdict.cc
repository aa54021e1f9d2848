#include "backend/run_verdict.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace arborslam {
namespace {

constexpr double kLostShare = 0.5;         // Of the scans measured, below which a run is lost.
constexpr double kMostUnmeasured = 0.02;   // Share of the scans without a measured pose that is usual.
constexpr size_t kFewUnmeasured = 2;       // Are no cause for alarm, however short the run.
constexpr size_t kLongestUnmeasured = 10;  // In a row, from which on a run is degraded.

std::string Range(size_t first, size_t last) {
  if (first == last) return "scan " + std::to_string(first + 1);
  return "scans " + std::to_string(first + 1) + " to " + std::to_string(last + 1);
}

// The longest run of scans without a measured pose, as indices of its first and last one.
std::optional<std::pair<size_t, size_t>> LongestUnmeasured(const std::vector<PoseSource>& sources) {
  std::optional<std::pair<size_t, size_t>> longest;
  size_t first = 0;
  for (size_t i = 0; i < sources.size(); ++i) {
    if (sources[i] == PoseSource::kMeasured) {
      first = i + 1;
    } else if (!longest || i - first > longest->second - longest->first) {
      longest.emplace(first, i);
    }
  }
  return longest;
}

}  // namespace

const char* ToString(RunState state) {
  switch (state) {
    case RunState::kOk:
      return "ok";
    case RunState::kDegraded:
      return "degraded";
    case RunState::kLost:
      return "lost";
  }
  return "unknown";
}

std::string TextOf(const RunVerdict& verdict) {
  std::string text = ToString(verdict.state);
  for (size_t i = 0; i < verdict.reasons.size(); ++i) text += (i == 0 ? ": " : "; ") + verdict.reasons[i];
  return text;
}

std::vector<bool> PlacedScans(const std::vector<PoseSource>& sources, const std::vector<MapSegment>& segments) {
  std::vector<bool> placed(sources.size(), false);
  for (size_t i = 0; i < sources.size(); ++i) placed[i] = sources[i] != PoseSource::kUnknown;
  for (const MapSegment& segment : segments) {
    if (segment.is_joined) continue;
    std::fill(placed.begin() + static_cast<std::ptrdiff_t>(segment.first_scan),
              placed.begin() + static_cast<std::ptrdiff_t>(segment.last_scan) + 1, false);
  }
  return placed;
}

RunVerdict JudgeRun(const std::vector<PoseSource>& sources, const std::vector<MapSegment>& segments,
                    const std::vector<size_t>& index_of) {
  RunVerdict verdict;
  const auto degrade = [&verdict](const std::string& reason) {
    if (verdict.state == RunState::kOk) verdict.state = RunState::kDegraded;
    verdict.reasons.push_back(reason);
  };
  const std::vector<bool> placed = PlacedScans(sources, segments);
  size_t num_usable = 0;
  size_t num_unmeasured = 0;
  for (size_t i = 0; i < sources.size(); ++i) {
    const bool is_measured = sources[i] == PoseSource::kMeasured;
    num_usable += is_measured && placed[i] ? 1 : 0;
    num_unmeasured += is_measured ? 0 : 1;
  }
  const auto num_scans = static_cast<double>(sources.size());
  if (static_cast<double>(num_usable) < kLostShare * num_scans) {
    verdict.state = RunState::kLost;
    verdict.reasons.push_back("only " + std::to_string(num_usable) + " of " + std::to_string(sources.size()) +
                              " scans were placed in one map");
  }
  const auto num_apart = static_cast<size_t>(
      std::count_if(segments.begin(), segments.end(), [](const MapSegment& segment) { return !segment.is_joined; }));
  if (segments.size() > 1) {
    degrade("tracking was lost " + std::to_string(segments.size() - 1) + " times, first after " +
            Range(index_of[segments[0].last_scan], index_of[segments[0].last_scan]) +
            (num_apart == 0 ? "; all segments were joined" : ""));
  }
  if (num_apart > 0) {
    constexpr size_t kMostNamed = 3;
    std::string names;
    size_t num_named = 0;
    for (const MapSegment& segment : segments) {
      if (segment.is_joined || num_named == kMostNamed) continue;
      names += (num_named++ == 0 ? "" : ", ") + Range(index_of[segment.first_scan], index_of[segment.last_scan]);
    }
    degrade(std::to_string(num_apart) + " of " + std::to_string(segments.size()) +
            " segments were not joined to the map (" + names + (num_apart > kMostNamed ? ", ..." : "") + ")");
  }
  const std::optional<std::pair<size_t, size_t>> longest = LongestUnmeasured(sources);
  if (longest &&
      ((num_unmeasured > kFewUnmeasured && static_cast<double>(num_unmeasured) > kMostUnmeasured * num_scans) ||
       longest->second - longest->first + 1 >= kLongestUnmeasured)) {
    degrade(std::to_string(num_unmeasured) + " of " + std::to_string(sources.size()) +
            " scans were not matched, most in a row " + Range(index_of[longest->first], index_of[longest->second]));
  }
  return verdict;
}

}  // namespace arborslam
